#include "engine/physics/solvers/sparse_solver.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

using namespace tactus;

namespace {

/// The grid Laplacian plus a diagonal, with random links: positive definite, of no nice order.
Eigen::SparseMatrix<double> matrix(int n, int links) {
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
  Eigen::SparseMatrix<double> made(n, n);
  made.setFromTriplets(entries.begin(), entries.end());
  return made;
}

}  // namespace

TEST_CASE("sparse solver: what it finds is a solution", "[physics]") {
  const auto links = GENERATE(0, 1, 40, 200);
  const auto a = matrix(60, links);
  const SparseSolver solver(a);
  CHECK(solver.valid());
  CHECK(solver.diagonal() == (links == 0));
  std::vector<double> x(60), work(60), b(60);
  for (std::size_t i = 0; i < 60; ++i) x[i] = b[i] = std::sin(static_cast<double>(i));
  solver.solve(x, work);
  for (int column = 0; column < 60; ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, column); entry; ++entry)
      b[static_cast<std::size_t>(entry.row())] -= entry.value() * x[static_cast<std::size_t>(column)];
  for (const double left : b) CHECK(left == Approx(0.0).margin(1e-13));
}

TEST_CASE("sparse solver: a chain fills in nothing", "[physics]") {
  Eigen::SparseMatrix<double> a(1000, 1000);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < 1000; ++i) entries.emplace_back(i, i, 3.0);
  for (int i = 1; i < 1000; ++i) entries.emplace_back(i, i - 1, -1.0), entries.emplace_back(i - 1, i, -1.0);
  a.setFromTriplets(entries.begin(), entries.end());
  CHECK(SparseSolver(a).multiplications() == 1000 + 2 * 999);
}

TEST_CASE("sparse solver: says so when there is nothing to solve", "[physics]") {
  Eigen::SparseMatrix<double> a(2, 2);
  a.insert(0, 0) = 1.0, a.insert(0, 1) = 2.0, a.insert(1, 0) = 2.0, a.insert(1, 1) = 1.0;
  CHECK_FALSE(SparseSolver(a).valid());
}
