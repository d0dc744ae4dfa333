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

}  // namespace tactus
