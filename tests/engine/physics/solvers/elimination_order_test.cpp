#include "engine/physics/solvers/elimination_order.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/engine/physics/solvers/grid_matrix.h"

using namespace tactus;

namespace {

std::vector<int> dissected(const Eigen::SparseMatrix<double>& matrix) {
  return nested_dissection_order(matrix, minimum_degree_order(matrix));
}

bool names_each_once(std::vector<int> order, Eigen::Index rows) {
  std::sort(order.begin(), order.end());
  std::vector<int> all(static_cast<std::size_t>(rows));
  std::iota(all.begin(), all.end(), 0);
  return order == all;
}

}  // namespace

TEST_CASE("elimination_order: a dissected grid fills in as theory bounds it", "[physics]") {
  // George 1973: 31/4 s^2 log2(s) for s x s unknowns with nine-point links, more than these have.
  const int side = GENERATE(16, 31, 32, 100, 200);
  const auto matrix = test::grid_matrix(side, side, 1.0);
  const auto order = dissected(matrix);
  CHECK(names_each_once(order, matrix.rows()));
  CHECK(static_cast<double>(factor_entries(matrix, order)) < 7.75 * side * side * std::log2(side));
}

TEST_CASE("elimination_order: the numbering of a grid does not matter", "[physics]") {
  // Shuffled, so that only the links remain to find rows and columns from.
  const int rows = 40, columns = 60;
  const auto matrix = test::grid_matrix(rows, columns, 1.0);
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> shuffle(matrix.rows());
  shuffle.setIdentity();
  std::mt19937 random(1);
  std::shuffle(shuffle.indices().begin(), shuffle.indices().end(), random);
  Eigen::SparseMatrix<double> shuffled;
  shuffled = matrix.twistedBy(shuffle);
  const auto entries = static_cast<double>(factor_entries(matrix, dissected(matrix)));
  CHECK(static_cast<double>(factor_entries(shuffled, dissected(shuffled))) == Approx(entries).epsilon(0.05));
}

TEST_CASE("elimination_order: parts that nothing joins, and graphs without a small separator", "[physics]") {
  std::vector<Eigen::Triplet<double>> entries;
  const int n = 300;
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, 1.0);
  for (int i = 0; i < 100; ++i)  // each with each
    for (int j = 0; j < i; ++j) entries.emplace_back(i, j, -1.0);
  for (int i = 101; i < 200; ++i) entries.emplace_back(i, 100, -1.0);  // a star; 200 to 299 alone
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const auto order = dissected(matrix);
  CHECK(names_each_once(order, n));
  CHECK(factor_entries(matrix, order) == 100 * 99 / 2 + 99);
}
