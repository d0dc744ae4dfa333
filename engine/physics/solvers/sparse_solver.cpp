#include "engine/physics/solvers/sparse_solver.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/index.h"
#include "engine/physics/solvers/elimination_order.h"

namespace tactus {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Factor = Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>>;

// Fewer rows are solved one by one. So at most half of all lanes are idle.
constexpr int kFewestInLanes = 4;

// In numbers added one by one: what a column of eight costs, and what a row besides its numbers.
constexpr double kColumnCost = 2.0, kRowCost = 4.0;

// An order that leaves so many times the numbers of another is no better, whatever they cost.
constexpr std::size_t kMostFill = 3;

/// How many rows the farthest number lies from the diagonal. Up to 1, the own order fills in nothing.
int bandwidth(const Sparse& matrix) {
  int most = 0;
  for (int column = 0; column < matrix.outerSize(); ++column)
    for (Sparse::InnerIterator entry(matrix, column); entry; ++entry)
      if (entry.value() != 0.0) most = std::max(most, std::abs(static_cast<int>(entry.row() - entry.col())));
  return most;
}

/// P A P^T = L D L^T.
class Factored {
 public:
  Factored(const Sparse& matrix, std::vector<int> rows) : order(std::move(rows)) {
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> place(matrix.rows());
    for (int i = 0; i < matrix.rows(); ++i) place.indices()[order[index(i)]] = i;
    Sparse permuted(matrix.rows(), matrix.cols());
    permuted.selfadjointView<Eigen::Lower>() = matrix.selfadjointView<Eigen::Lower>().twistedBy(place);
    const Factor factor(permuted);
    valid = factor.info() == Eigen::Success;
    if (!valid) return;
    diagonal = factor.vectorD();
    lower = factor.matrixL();
    scaled_rows = diagonal.asDiagonal() * Sparse(lower.transpose());
    find_strips();
  }

  bool valid = false;
  std::vector<int> order;
  Eigen::VectorXd diagonal;
  Sparse lower;        ///< L
  Sparse scaled_rows;  ///< the rows of L D as columns
  std::vector<Strip> strips;
  double cost = 0.0;

 private:
  /// Rows that follow each other in the elimination tree, without a branch between them, have most of their
  /// columns in common.
  void find_strips() {
    const auto n = static_cast<int>(lower.cols());
    std::vector<int> parent(index(n), n), children(index(n) + 1);
    for (int column = 0; column < n; ++column) {
      Sparse::InnerIterator below(lower, column);
      if (++below) parent[index(column)] = static_cast<int>(below.row());
      ++children[index(parent[index(column)])];
    }
    const auto goes_on = [&](const Strip& strip) {
      return strip.end() < n && strip.rows < Lanes::kCount && parent[index(strip.end() - 1)] == strip.end() &&
             children[index(strip.end())] == 1;
    };
    for (int first = 0; first < n; first = strips.back().end()) {
      Strip strip{first, 1, true};
      while (goes_on(strip)) ++strip.rows;
      append(strip);
    }
  }

  /// In lanes or row by row, as is cheaper.
  void append(const Strip& strip) {
    const auto columns =
        outer_columns(lower, strip).size() + outer_columns(scaled_rows, strip).size() + 2 * Lanes::kCount;
    const double in_lanes = kColumnCost * static_cast<double>(columns);
    double one_by_one = 0.0;
    for (int row = strip.first; row < strip.end(); ++row)
      one_by_one +=
          kRowCost + static_cast<double>(lower.col(row).nonZeros() + scaled_rows.col(row).nonZeros());
    cost += std::min(in_lanes, one_by_one);
    if (strip.rows >= kFewestInLanes && in_lanes < one_by_one) return strips.push_back(strip);
    for (int row = strip.first; row < strip.end(); ++row) strips.push_back({row, 1, false});
  }
};

/// In the order that is cheaper.
Factored factored(const Sparse& matrix) {
  const auto minimum_degree = minimum_degree_order(matrix);
  Factored best(matrix, minimum_degree);
  const auto dissected = nested_dissection_order(matrix, minimum_degree);
  if (!best.valid || factor_entries(matrix, dissected) > kMostFill * index(best.lower.nonZeros()))
    return best;
  Factored other(matrix, dissected);
  return other.valid && other.cost < best.cost ? other : best;
}

/// Those in lanes first, so that they begin with a cache line.
int assign_slots(std::vector<Strip>& strips) {
  int slots = 0;
  for (const bool in_lanes : {true, false})
    for (auto& strip : strips)
      if (strip.in_lanes == in_lanes) strip.slot = std::exchange(slots, slots + strip.slots());
  return slots;
}

}  // namespace

void SparseSolver::take_diagonal(const Eigen::VectorXd& diagonal) {
  for (const double d : diagonal) {
    inverse_.push_back(1.0 / d);
    valid_ = valid_ && inverse_.back() > 0.0 && std::isfinite(inverse_.back());
  }
}

SparseSolver::SparseSolver(const Sparse& matrix) {
  const int band = bandwidth(matrix);
  if (band == 0)
    take_diagonal(matrix.diagonal());
  else if (band == 1)
    factor_chain(matrix);
  else
    factor(matrix);
}

void SparseSolver::factor_chain(const Sparse& matrix) {
  const Factor factor(matrix);
  valid_ = factor.info() == Eigen::Success;
  if (!valid_) return;
  take_diagonal(factor.vectorD());
  const Sparse lower = factor.matrixL();
  entries_ = index(lower.nonZeros()) - inverse_.size();
  below_.resize(inverse_.size());
  for (int column = 0; column + 1 < lower.cols(); ++column)
    below_[index(column)] = lower.coeff(column + 1, column);
}

void SparseSolver::factor(const Sparse& matrix) {
  const auto factor = factored(matrix);
  valid_ = factor.valid;
  if (!valid_) return;
  take_diagonal(factor.diagonal);
  entries_ = index(factor.lower.nonZeros()) - inverse_.size();
  // L D y = P b, then L^T P x = y.
  auto strips = TriangularSweep::schedule(factor.scaled_rows, factor.strips);
  row_.resize(index(assign_slots(strips)));
  slot_.resize(inverse_.size());
  forward_ = TriangularSweep(factor.scaled_rows, strips);
  backward_ = TriangularSweep(factor.lower,
                              TriangularSweep::schedule(factor.lower, {strips.rbegin(), strips.rend()}));
  for (const auto& strip : strips) {
    for (int lane = 0; lane < strip.slots(); ++lane) {
      // Idle lanes get a number of the last row, which nothing reads.
      const int row = strip.first + std::min(lane, strip.rows - 1), slot = strip.slot + lane;
      row_[index(slot)] = factor.order[index(row)];
      if (lane < strip.rows) slot_[index(factor.order[index(row)])] = slot;
    }
  }
}

/// The last result stays in a register.
void SparseSolver::solve_chain(std::span<double> b) const noexcept {
  const std::size_t n = inverse_.size();
  double x = b[0];
  for (std::size_t i = 1; i < n; ++i) b[i] = x = b[i] - below_[i - 1] * x;
  b[n - 1] = x = b[n - 1] * inverse_[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) b[i] = x = b[i] * inverse_[i] - below_[i] * x;
}

void SparseSolver::solve(std::span<double> b, std::span<double> work) const noexcept {
  const std::size_t n = inverse_.size();
  if (diagonal()) {
    for (std::size_t i = 0; i < n; ++i) b[i] *= inverse_[i];
    return;
  }
  if (!below_.empty()) return solve_chain(b);
  for (std::size_t i = 0; i < row_.size(); ++i) work[i] = b[index(row_[i])];
  forward_.solve(work.data());
  backward_.solve(work.data());
  for (std::size_t i = 0; i < n; ++i) b[i] = work[index(slot_[i])];
}

}  // namespace tactus
