#pragma once

#include <Eigen/SparseCore>
#include <vector>

namespace tactus::test {

/// Masses of 1 on a grid whose neighbours are joined by `stiffness`, row by row; the rim is joined to the
/// ground.
inline Eigen::SparseMatrix<double> grid_matrix(int rows, int columns, double stiffness) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto link = [&](int one, int other) {
    entries.emplace_back(one, other, -stiffness), entries.emplace_back(other, one, -stiffness);
  };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const int here = row * columns + column;
      entries.emplace_back(here, here, 1.0 + 4.0 * stiffness);
      if (column + 1 < columns) link(here, here + 1);
      if (row + 1 < rows) link(here, here + columns);
    }
  Eigen::SparseMatrix<double> matrix(rows * columns, rows * columns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace tactus::test
