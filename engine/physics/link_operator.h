#pragma once

#include <span>
#include <vector>

namespace tactus {

/// The linear forces in a network: y = c - K q - B u, where row i belongs to mass i,
/// K and B are symmetric between masses, and the columns are the
/// masses and after them the driven points. Entries that lie along diagonals (chains, grids) are stored by
/// diagonals and run at the speed of the memory; the rest one by one, sorted by mass.
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
    std::vector<double> k, b;
  };
  void split();
  bool is_chain() const;
  void apply_chain(const double* q, const double* u, double* y) const noexcept;
  void apply_diagonals(const double* q, const double* u, double* y) const noexcept;

  std::vector<Entry> entries_, scattered_;
  std::vector<Diagonal> diagonals_;
  std::vector<double> constant_;
  bool chain_ = false;  ///< diagonals -1, 0 and 1, all complete
};

}  // namespace tactus
