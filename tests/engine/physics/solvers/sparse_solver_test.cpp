#include "engine/physics/solvers/sparse_solver.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/engine/physics/solvers/grid_matrix.h"

using namespace tactus;

namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr double kRounding = std::numeric_limits<double>::epsilon();

/// The Laplacian of random links plus a diagonal: positive definite, of no nice order.
Sparse matrix(int n, int links) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> any(0, n - 1);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, 1.0 + 0.1 * i);
  for (int l = 0; l < links; ++l) {
    const int a = any(random), b = any(random);
    if (a == b) continue;
    entries.emplace_back(a, a, 2.0), entries.emplace_back(b, b, 2.0);
    entries.emplace_back(a, b, -2.0), entries.emplace_back(b, a, -2.0);
  }
  Sparse made(n, n);
  made.setFromTriplets(entries.begin(), entries.end());
  return made;
}

/// A grid without the masses in its middle, with a few springs across it.
Sparse grid_with_a_hole(int side, double stiffness) {
  Sparse made = test::grid_matrix(side, side, stiffness);
  for (int row = side / 3; row < side / 2; ++row)
    for (int column = side / 3; column < side / 2; ++column) {
      const int hole = row * side + column;
      for (const int next : {hole - 1, hole + 1, hole - side, hole + side})
        made.coeffRef(hole, next) = made.coeffRef(next, hole) = 0.0;
    }
  for (int i = 0; i < 3; ++i) {
    const int far = side * side - 2 * i - 1;
    made.coeffRef(i, far) = made.coeffRef(far, i) = -0.1;
  }
  return made;
}

Eigen::VectorXd solved(const SparseSolver& solver, Eigen::VectorXd x) {
  std::vector<double> work(solver.workspace());
  solver.solve({x.data(), static_cast<std::size_t>(x.size())}, work);
  return x;
}

Eigen::VectorXd sines(Eigen::Index n) {
  return Eigen::VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)).array().sin();
}

/// The smallest change of A, relative to its largest row, that makes x exact: a backward error.
double backward_error(const Sparse& a, const Eigen::VectorXd& x, const Eigen::VectorXd& b) {
  const double largest = (a.cwiseAbs() * Eigen::VectorXd::Ones(a.cols())).maxCoeff();
  return (a * x - b).cwiseAbs().maxCoeff() / (largest * x.cwiseAbs().maxCoeff());
}

/// |A| |A^-1| as largest row sums, at most: where a diagonal exceeds the rest of its row by d or more, |A^-1|
/// is at most 1 / d (Varah, Linear Algebra Appl. 11, 1975).
double condition(const Sparse& a) {
  const Eigen::VectorXd rows = a.cwiseAbs() * Eigen::VectorXd::Ones(a.cols());
  const double excess = (2.0 * a.diagonal() - rows).minCoeff();
  REQUIRE(excess > 0.0);
  return rows.maxCoeff() / excess;
}

}  // namespace

TEST_CASE("sparse solver: what it finds is a solution", "[physics]") {
  const auto links = GENERATE(0, 1, 40, 200, 2000);
  const auto a = matrix(60, links);
  const SparseSolver solver(a);
  CHECK(solver.valid());
  CHECK(solver.diagonal() == (links == 0));
  CHECK(solver.workspace() <= 120);
  const auto b = sines(60);
  CHECK(backward_error(a, solved(solver, b), b) < 4 * kRounding);
}

TEST_CASE("sparse solver: grids are solved as by a dense factor, to rounding", "[physics]") {
  const int side = GENERATE(3, 7, 13, 32);
  const double stiffness = GENERATE(0.025, 25.0);
  const auto a =
      GENERATE_COPY(test::grid_matrix(side, side, stiffness),
                    test::grid_matrix(side, 2 * side + 1, stiffness), grid_with_a_hole(side, stiffness));
  const SparseSolver solver(a);
  REQUIRE(solver.valid());
  CHECK(solver.workspace() <= 2 * static_cast<std::size_t>(a.rows()));
  const auto b = sines(a.rows());
  const Eigen::VectorXd x = solved(solver, b), dense = Eigen::MatrixXd(a).llt().solve(b);
  // |x - dense| <= |A^-1| |A| (the backward errors of both) |x|. The sums of the dense factor are as long as
  // A has rows: its rounding, of random sign, grows with the root of that (Higham & Mary, SIAM J. Sci.
  // Comput. 41, 2019). Those of the sparse factor are shorter.
  const double sparse_error = backward_error(a, x, b) / kRounding;
  const double dense_error = std::sqrt(static_cast<double>(a.rows()));
  CHECK(sparse_error < dense_error);
  CHECK((x - dense).cwiseAbs().maxCoeff() / (kRounding * x.cwiseAbs().maxCoeff()) <
        condition(a) * (sparse_error + dense_error));
}

TEST_CASE("sparse solver: however stiff a grid is, the solution is that of a matrix next to it",
          "[physics]") {
  const double stiffness = GENERATE(1.0, 1e4, 1e8, 1e12);
  const auto a = test::grid_matrix(40, 40, stiffness);
  const SparseSolver solver(a);
  REQUIRE(solver.valid());
  const auto b = GENERATE_COPY(sines(1600), Eigen::VectorXd(Eigen::VectorXd::Unit(1600, 777)),
                               Eigen::VectorXd(a * sines(1600)));
  CHECK(backward_error(a, solved(solver, b), b) < 4 * kRounding);
}

TEST_CASE("sparse solver: a grid of n rows costs no more than 31/4 n log2(n)", "[physics]") {
  const SparseSolver solver(test::grid_matrix(100, 100, 1.0));
  CHECK(static_cast<double>(solver.multiplications()) < 7.75 * 1e4 * std::log2(1e4));
}

TEST_CASE("sparse solver: nothing of a right-hand side remains in the workspace", "[physics]") {
  const SparseSolver solver(test::grid_matrix(13, 13, 1.0));
  const auto b = sines(169);
  std::vector<double> work(solver.workspace(), std::numeric_limits<double>::quiet_NaN());
  Eigen::VectorXd x = b;
  solver.solve({x.data(), 169}, work);
  CHECK(x == solved(solver, b));
}

TEST_CASE("sparse solver: a chain fills in nothing", "[physics]") {
  CHECK(SparseSolver(test::grid_matrix(1, 1000, 1.0)).multiplications() == 1000 + 2 * 999);
}

TEST_CASE("sparse solver: says so when there is nothing to solve", "[physics]") {
  const auto rows = GENERATE(1, 20);
  auto a = test::grid_matrix(rows, 2, 1.0);
  a.coeffRef(0, 0) = -1.0;
  CHECK_FALSE(SparseSolver(a).valid());
}
