#pragma once
// Thread: [control]

#include <Eigen/Core>

namespace tactus {

/// e^A - 1, A square: by how much x' = A x changes x in a unit of time.
///
/// With B = A / 2^s, |B|_1 <= 1/32:  F_0 = B + B^2/2! + ... + B^8/8!,  F_(j+1) = 2 F_j + F_j^2,  F_s = e^A
/// - 1. Squaring e^B itself would round each slow motion, which changes by |B| in such a part, to the unit
/// roundoff u: an error of u |A| at the end. F keeps its digits: what decays tends to -1, where 2 F + F^2
/// forgets errors, and for slow motions an error relative to their own change remains. Scale the states
/// first, so that A is about as large as its eigenvalues: squaring loses digits where it is far from normal
/// (Al-Mohy & Higham, SIAM J. Matrix Anal. Appl. 31, 2009).
Eigen::MatrixXd change_over(const Eigen::MatrixXd& rates);

}  // namespace tactus
