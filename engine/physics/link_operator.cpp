#include "engine/physics/link_operator.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>
#include <tuple>

namespace tactus {
namespace {

// Below this many entries on a diagonal the loop over it costs more than it saves.
constexpr std::size_t kShortestDiagonal = 16;

// So many sums stay in the nearest cache while the diagonals pass over them.
constexpr int kRowsAtOnce = 512;

using Numbers = Eigen::Map<const Eigen::ArrayXd>;

}  // namespace

LinkOperator::LinkOperator(std::vector<Entry> entries, std::vector<double> constant)
    : constant_(std::move(constant)) {
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.row, a.column) < std::tie(b.row, b.column);
  });
  for (const auto& entry : entries) {
    if (!entries_.empty() && entries_.back().row == entry.row && entries_.back().column == entry.column) {
      entries_.back().k += entry.k;
      entries_.back().b += entry.b;
    } else {
      entries_.push_back(entry);
    }
  }
  split();
}

void LinkOperator::split() {
  std::map<int, std::vector<Entry>> by_offset;
  for (const auto& entry : entries_) by_offset[entry.column - entry.row].push_back(entry);
  for (const auto& [offset, list] : by_offset) {
    const int first = list.front().row;
    const auto span = static_cast<std::size_t>(list.back().row - first + 1);
    if (list.size() < kShortestDiagonal || 2 * list.size() < span) {
      scattered_.insert(scattered_.end(), list.begin(), list.end());
      continue;
    }
    Diagonal diagonal{offset, first, static_cast<int>(span), std::vector<double>(span),
                      std::vector<double>(span)};
    for (const auto& entry : list) {
      diagonal.k[static_cast<std::size_t>(entry.row - first)] = entry.k;
      diagonal.b[static_cast<std::size_t>(entry.row - first)] = entry.b;
    }
    diagonals_.push_back(std::move(diagonal));
  }
  chain_ = is_chain();
  std::sort(scattered_.begin(), scattered_.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.row, a.column) < std::tie(b.row, b.column);
  });
}

bool LinkOperator::is_chain() const {
  return diagonals_.size() == 3 && diagonals_[0].offset == -1 && diagonals_[1].offset == 0 &&
         diagonals_[2].offset == 1 && diagonals_[1].count == static_cast<int>(constant_.size()) &&
         diagonals_[0].count == diagonals_[1].count - 1 && diagonals_[2].count == diagonals_[0].count;
}

void LinkOperator::apply(const double* q, const double* u, double* y) const noexcept {
  if (chain_)
    apply_chain(q, u, y);
  else
    apply_diagonals(q, u, y);
  for (const auto& e : scattered_) y[e.row] -= e.k * q[e.column] + e.b * u[e.column];
}

/// One pass. K and B are symmetric, so what mass i feels from i - 1 is read from the row of i - 1.
void LinkOperator::apply_chain(const double* q, const double* u, double* y) const noexcept {
  const auto &own = diagonals_[1], &next = diagonals_[2];
  const int last = own.count - 1;
  y[0] = constant_[0] - (own.k[0] * q[0] + own.b[0] * u[0]) - (next.k[0] * q[1] + next.b[0] * u[1]);
  const auto n = last - 1;
  Eigen::Map<Eigen::ArrayXd>(y + 1, n) =
      Numbers(constant_.data() + 1, n) -
      (Numbers(own.k.data() + 1, n) * Numbers(q + 1, n) + Numbers(own.b.data() + 1, n) * Numbers(u + 1, n)) -
      (Numbers(next.k.data() + 1, n) * Numbers(q + 2, n) +
       Numbers(next.b.data() + 1, n) * Numbers(u + 2, n)) -
      (Numbers(next.k.data(), n) * Numbers(q, n) + Numbers(next.b.data(), n) * Numbers(u, n));
  const auto l = static_cast<std::size_t>(last);
  y[l] = constant_[l] - (own.k[l] * q[l] + own.b[l] * u[l]) -
         (next.k[l - 1] * q[l - 1] + next.b[l - 1] * u[l - 1]);
}

void LinkOperator::apply_diagonals(const double* q, const double* u, double* y) const noexcept {
  const auto rows = static_cast<int>(constant_.size());
  for (int from = 0; from < rows; from += kRowsAtOnce) {
    const int to = std::min(rows, from + kRowsAtOnce);
    std::copy(constant_.begin() + from, constant_.begin() + to, y + from);
    for (const auto& d : diagonals_) {
      const int first = std::max(from, d.first), count = std::min(to, d.first + d.count) - first;
      if (count <= 0) continue;
      const int column = first + d.offset, entry = first - d.first;
      Eigen::Map<Eigen::ArrayXd>(y + first, count) -=
          Numbers(d.k.data() + entry, count) * Numbers(q + column, count) +
          Numbers(d.b.data() + entry, count) * Numbers(u + column, count);
    }
  }
}

}  // namespace tactus
