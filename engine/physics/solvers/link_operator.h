#pragma once

// Thread: [any], except where a function says otherwise
#include <span>
#include <vector>

#include "engine/physics/numbers.h"

namespace tactus {

/// The linear forces in a network: y = c - K q - B u, where row i belongs to mass i,
/// K and B are symmetric between masses, and the columns are the
/// masses and after them the driven points. Entries that lie along diagonals (chains, grids) are applied to
/// registers of masses, in one pass over the memory; the rest mass by mass.
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

  /// What `apply` adds up, in its order: what a program needs that does so mass by mass, with the same bits.
  struct Sums {
    /// Neighbours alone: what both ends of a link feel is worked out once. Else the lists below are empty.
    bool chain = false, below_first = false;
    std::vector<double> constant, own_k, own_b, next_k, next_b;
    std::vector<Entry> fused;  ///< row by row: sum = k q + sum, then b u + sum, each rounded once
    std::vector<Entry> plain;  ///< then, row by row: sum = sum - (k q + b u)
  };
  /// [control]
  Sums sums() const;

 private:
  struct Diagonal {
    int offset, first, count;  // rows first ... first + count - 1; column = row + offset
    AlignedNumbers k, b;

    bool covers(int row) const { return row >= first && row < first + count; }
  };
  /// Rows with numbers on the same diagonals.
  struct Band {
    int first, count;
    bool goes_on;              // adds to what another band leaves in these rows
    std::vector<int> offsets;  // of each diagonal
    AlignedNumbers values;     // register by register of rows, and then row by row: -k, -b of each diagonal
  };
  void split();
  void arrange_bands();
  Band band(int first, int last, std::span<const Diagonal* const> diagonals) const;
  bool is_chain() const;
  bool few() const;
  struct ChainPass;
  template <bool BelowFirst>
  void apply_chain(const double* q, const double* u, double* y) const noexcept;
  template <int Diagonals>
  void apply_band(const Band& band, const double* q, const double* u, double* y) const noexcept;
  void apply_bands(const double* q, const double* u, double* y) const noexcept;
  void apply_scattered(const double* q, const double* u, double* y) const noexcept;

  std::vector<Entry> entries_;
  std::vector<Diagonal> diagonals_;  ///< of a chain
  std::vector<Band> bands_;          ///< of the others
  std::vector<Entry> scattered_;     ///< on no diagonal, row by row
  AlignedNumbers constant_;
  bool chain_ = false;  ///< diagonals -1, 0 and 1, all complete
};

/// One explicit step of masses in a row, in one pass over the memory:
///     f_i = k_i (q_i - q_i+1) + b_i (u_i - u_i+1)            thrust between neighbours
///     e_i = s_i (f_i-1 - f_i - K_i q_i - B_i u_i + p_i)      K, B: to whatever is fixed
///     u+ = u + e,   q+ = q + u+
/// with q [m], u = q - q- [m], s = step^2 / mass [s^2/kg], and p [N] whatever else pushes. Each thrust is
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

  /// What each mass is stepped with, and whether it may be pushed.
  struct Masses {
    std::vector<double> k, b, own_k, own_b, scale;
    std::vector<bool> pushed;
  };
  /// [control]
  Masses numbers() const;

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

  AlignedNumbers k_, b_, own_k_, own_b_, scale_;  // own: -K, -B
  std::vector<Run> runs_;
};

}  // namespace tactus
