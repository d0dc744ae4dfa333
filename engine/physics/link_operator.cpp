#include "engine/physics/link_operator.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>
#include <tuple>

namespace tactus {
namespace {

// Below this many entries on a diagonal the loop over it costs more than it saves.
constexpr std::size_t kShortestDiagonal = 16;

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
  std::sort(scattered_.begin(), scattered_.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.row, a.column) < std::tie(b.row, b.column);
  });
}

void LinkOperator::apply(const double* q, const double* u, double* y) const noexcept {
  std::copy(constant_.begin(), constant_.end(), y);
  for (const auto& d : diagonals_) {
    const auto column = d.first + d.offset;
    Eigen::Map<Eigen::ArrayXd>(y + d.first, d.count) -=
        Numbers(d.k.data(), d.count) * Numbers(q + column, d.count) +
        Numbers(d.b.data(), d.count) * Numbers(u + column, d.count);
  }
  for (const auto& e : scattered_) y[e.row] -= e.k * q[e.column] + e.b * u[e.column];
}

}  // namespace tactus
