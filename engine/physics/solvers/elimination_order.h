#pragma once

// Thread: [control]
#include <Eigen/SparseCore>
#include <vector>

namespace tactus {

/// Orders in which to eliminate the unknowns of a symmetric matrix, such that its factor stays sparse. Entry
/// i of an order is the row of the matrix that is eliminated i-th. Both halves of the matrix or its lower
/// one.

/// Approximate minimum degree (Amestoy, Davis & Duff, SIAM J. Matrix Anal. Appl. 17, 1996): for graphs
/// without small separators.
std::vector<int> minimum_degree_order(const Eigen::SparseMatrix<double>& matrix);

/// Nested dissection (George, SIAM J. Numer. Anal. 10, 1973): a separator is eliminated after the two parts
/// that it separates, and these likewise. A grid of n unknowns keeps at most 31/8 n log2(n) numbers.
///
/// Only the graph of the matrix is used. Its coordinates are differences of the distances from three
/// landmarks: in a rectangular grid these are corners, and the differences of distances from two neighbouring
/// corners are the grid's rows and columns. Of the separators in the middle of each coordinate the one that
/// is smallest for the parts it leaves is taken. Parts of up to 32 unknowns are ordered along their longer
/// side, parts without a small separator as `minimum_degree` (an order) has them.
std::vector<int> nested_dissection_order(const Eigen::SparseMatrix<double>& matrix,
                                         const std::vector<int>& minimum_degree);

/// Numbers in the factor below its diagonal, if the unknowns are eliminated in this order.
std::size_t factor_entries(const Eigen::SparseMatrix<double>& matrix, const std::vector<int>& order);

}  // namespace tactus
