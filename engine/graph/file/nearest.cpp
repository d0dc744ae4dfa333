#include "engine/graph/file/nearest.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace tactus {
namespace {

// Nobody means a name of this length by mistake, and the comparison costs the product of the lengths.
constexpr std::size_t kLongest = 64;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
bool same(char a, char b) { return lower(a) == lower(b); }

/// Letters to insert, remove, replace or swap with their neighbour (Damerau, Comm. ACM 7(3), 1964), in the
/// variant that edits no part of a word twice; capitals count as small letters.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view wrong, std::span<const std::string> candidates) {
  if (wrong.size() > kLongest) return {};
  // A third of the letters: "lowpas" is meant as "lowpass", "gain" is not meant as "ramp".
  std::size_t least = (wrong.size() + 1) / 3 + 1;
  std::string nearest;
  for (const auto& candidate : candidates) {
    if (candidate.size() > kLongest) continue;
    const auto letters = distance(wrong, candidate);
    if (letters >= least) continue;
    least = letters;
    nearest = candidate;
  }
  return nearest;
}

}  // namespace tactus
