#pragma once

// Thread: [any], except where a function says otherwise
#include <Eigen/SparseCore>
#include <vector>

#include "engine/physics/numbers.h"

namespace tactus {

/// Consecutive rows of a sparse triangular matrix that are solved for together: up to eight in the lanes of a
/// register, or one by itself.
struct Strip {
  int first, rows;
  bool in_lanes;
  int slot = 0;   ///< of its first row in the vector: eight, or one
  int level = 0;  ///< how many others it needs, one after the other

  int end() const { return first + rows; }
  int slots() const { return in_lanes ? Lanes::kCount : 1; }
};

/// Solves T x = b for one sparse triangular T, again and again:
///     x_S = T_SS^-1 (b_S - sum of T_Sc x_c over the columns c outside S)
/// for each strip S of rows. A column counts as often for eight rows as for one of them, so rows of a strip
/// should have most of their columns in common. T_SS^-1 is small and well conditioned but for its scale: the
/// solution is as exact as that of row by row (Higham & Pothen, SIAM J. Sci. Comput. 15, 1994).
///
/// T is handed over with its rows stored as columns.
class TriangularSweep {
 public:
  /// [control] Another order in which the strips can be solved one after the other, given one: those that
  /// need nothing of each other side by side, so that a processor need not wait for one before it begins the
  /// next.
  static std::vector<Strip> schedule(const Eigen::SparseMatrix<double>& rows,
                                     const std::vector<Strip>& strips);

  TriangularSweep() = default;
  /// [control] Strips as scheduled, with their slots.
  TriangularSweep(const Eigen::SparseMatrix<double>& rows, const std::vector<Strip>& strips);

  /// [realtime] b becomes x, both in slots. Idle lanes have to be finite.
  void solve(double* x) const noexcept;

  struct Sum {
    int slot, columns;
    std::size_t values;  ///< where they begin
  };
  /// Strips one after the other, all in lanes or none.
  struct Run {
    bool in_lanes;
    std::size_t end;
  };
  /// [any] What `solve` goes through.
  const std::vector<Run>& runs() const { return runs_; }
  const std::vector<Sum>& sums() const { return sums_; }
  const std::vector<int>& slots() const { return slots_; }
  const AlignedNumbers& values() const { return values_; }

 private:
  struct Work;

  std::size_t append(const std::vector<double>& values, std::size_t alignment);
  void append(const Work& work, std::size_t values);

  std::vector<Run> runs_;
  std::vector<Sum> sums_;
  std::vector<int> slots_;  ///< of the columns of each sum
  AlignedNumbers values_;   ///< -T_Sc, then T_SS^-1, both by columns; sums with the same numbers share them
};

/// The columns outside a strip in which one of its rows has a number, in rising order.
std::vector<int> outer_columns(const Eigen::SparseMatrix<double>& rows, const Strip& strip);

}  // namespace tactus
