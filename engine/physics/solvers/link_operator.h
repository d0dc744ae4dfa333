#pragma once

// Thread: [any], except where a function says otherwise
#include <span>
#include <vector>

#include "engine/physics/numbers.h"

namespace tactus {

/// The linear forces in a network: y = c - K q - B u, where row i belongs to mass i,
/// K and B are symmetric between masses, and the columns are the
/// masses and after them the driven points. Entries that lie along diagonals (chains, grids) are stored by
/// diagonals and run at the speed of the memory; the rest mass by mass.
class LinkOperator {
 public:
  struct Entry {
    int row, column;
    double k, b;
    double inertia = 0.0;  ///< not applied: what implicit solvers add to a stiff damper
  };

  LinkOperator() = default;
  /// [control] Entries of one place add up. `constant` has one number a mass.
  LinkOperator(std::vector<Entry> entries, std::vector<double> constant);

  /// [realtime] q and u hold all columns; y one number a mass.
  void apply(const double* q, const double* u, double* y) const noexcept;

  /// [any] After adding up, sorted by row, then column.
  std::span<const Entry> entries() const { return entries_; }

 private:
  struct Diagonal {
    int offset, first, count;  // rows first ... first + count - 1; column = row + offset
    AlignedNumbers k, b;
  };
  void split();
  bool is_chain() const;
  bool few() const;
  struct ChainPass;
  template <bool BelowFirst>
  void apply_chain(const double* q, const double* u, double* y) const noexcept;
  void apply_diagonals(const double* q, const double* u, double* y) const noexcept;

  void apply_scattered(const double* q, const double* u, double* y) const noexcept;

  std::vector<Entry> entries_;
  std::vector<Diagonal> diagonals_;
  std::vector<Entry> scattered_;  ///< on no diagonal, row by row
  AlignedNumbers constant_;
  bool chain_ = false;  ///< diagonals -1, 0 and 1, all complete
};

/// One explicit step of masses in a row, in one pass over the memory:
///     f_i = k_i (q_i+1 - q_i) + b_i (u_i+1 - u_i)            tension between neighbours
///     e_i = s_i (f_i - f_i-1 - K_i q_i - B_i u_i + p_i)      K, B: to whatever is fixed
///     u+ = u + e,   q+ = q + u+
/// with q [m], u = q - q- [m], s = step^2 / mass [s^2/kg], and p [N] whatever else pushes. Each tension is
/// worked out once and acts on both of its masses: action equals reaction to the bit. Where neighbours are
/// alike (chains, rings) their numbers stay in registers: of the memory only q, u and u+ are passed.
class MassRow {
 public:
  MassRow() = default;
  /// [control] `links` as in `LinkOperator::entries`; takes those between neighbours and on the diagonal and
  /// leaves the others in `left`. `scale` is s.
  MassRow(std::span<const LinkOperator::Entry> links, std::span<const double> scale,
          std::vector<LinkOperator::Entry>& left);

  /// [control] Whatever pushes may push these masses only (none at first); the others' p is never read.
  void let_push(const std::vector<bool>& masses);

  /// [realtime] p = `rest` where something may push.
  void fill(const double* rest, double* push) const noexcept;
  /// [realtime] q becomes q+; u and u+ are two places.
  void step(double* q, const double* u, double* u_next, const double* push) const noexcept;

 private:
  /// Masses that are stepped in lanes, first ... last - 1: all with the same numbers, each with its own, or
  /// such that something may push.
  struct Run {
    enum class Kind { Alike, Own, Pushed } kind;
    int first, last;
  };
  struct Pass;
  template <Run::Kind kind>
  static Lanes step_lanes(const Pass& where, const Run& run, Lanes below) noexcept;

  int masses() const { return static_cast<int>(scale_.size()); }
  int vectorised() const;
  bool alike(int one, int other) const;
  Run::Kind kind_of(int first, const std::vector<bool>& pushed) const;

  AlignedNumbers k_, b_, own_k_, own_b_, scale_;
  std::vector<Run> runs_;
};

}  // namespace tactus
