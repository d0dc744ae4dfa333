#include "engine/physics/solvers/triangular_sweep.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <tuple>
#include <unordered_map>

#include "engine/core/index.h"

namespace tactus {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Square = std::array<double, index(Lanes::kCount* Lanes::kCount)>;

template <class Visit>
void each_entry(const Sparse& rows, const Strip& strip, Visit visit) {
  for (int row = strip.first; row < strip.end(); ++row)
    for (Sparse::InnerIterator entry(rows, row); entry; ++entry)
      visit(row, static_cast<int>(entry.row()), entry.value());
}

bool inside(int row, const Strip& strip) { return row >= strip.first && row < strip.end(); }

/// By row: its strip's place in the list, its slot.
struct Places {
  std::vector<int> strip, slot;

  explicit Places(int rows, const std::vector<Strip>& strips) : strip(index(rows)), slot(index(rows)) {
    for (std::size_t s = 0; s < strips.size(); ++s)
      for (int row = strips[s].first; row < strips[s].end(); ++row) {
        strip[index(row)] = static_cast<int>(s);
        slot[index(row)] = strips[s].slot + row - strips[s].first;
      }
  }
};

/// Of the rows and columns of a strip, by columns: each by substitution, row by row from the end at which T
/// begins. Idle lanes count as rows of the unit matrix.
Square inverse_of(const Sparse& rows, const Strip& strip) {
  Square inner{}, inverse{};
  const auto at = [](Square& square, int row, int column) -> double& {
    return square[index(column * Lanes::kCount + row)];
  };
  for (int lane = 0; lane < Lanes::kCount; ++lane) at(inner, lane, lane) = 1.0;
  bool upper = false;
  each_entry(rows, strip, [&](int row, int column, double value) {
    if (!inside(column, strip)) return;
    at(inner, row - strip.first, column - strip.first) = value;
    upper = upper || column > row;
  });
  for (int column = 0; column < Lanes::kCount; ++column)
    for (int step = 0; step < Lanes::kCount; ++step) {
      const int row = upper ? Lanes::kCount - 1 - step : step;
      double sum = row == column ? 1.0 : 0.0;
      for (int other = 0; other < Lanes::kCount; ++other)
        if (other != row) sum -= at(inner, row, other) * at(inverse, other, column);
      at(inverse, row, column) = sum / at(inner, row, row);
    }
  return inverse;
}

template <class Vector>
Vector spread(double x) noexcept {
  if constexpr (std::is_same_v<Vector, double>)
    return x;
  else
    return Vector::broadcast(x);
}

// So many columns are added at a time, each to a sum of its own: else each would have to wait for the one
// before.
constexpr std::size_t kSums = 4;

/// In lanes columns are filled up with zeros, which cost less than a second loop.
std::size_t padded(std::size_t columns, const Strip& strip) {
  return strip.in_lanes ? (columns + kSums - 1) / kSums * kSums : columns;
}

/// Lists of numbers, those of the same bits only once. In a regular network many are the same.
class DistinctLists {
 public:
  std::size_t find(std::vector<double> list) {
    const auto hash = std::hash<std::string_view>{}(
        {reinterpret_cast<const char*>(list.data()), list.size() * sizeof(double)});
    const auto [first, last] = places_.equal_range(hash);
    for (auto it = first; it != last; ++it)
      if (same(all_[it->second], list)) return it->second;
    all_.push_back(std::move(list));
    return places_.emplace(hash, all_.size() - 1)->second;
  }
  const std::vector<std::vector<double>>& all() const { return all_; }

 private:
  static bool same(const std::vector<double>& one, const std::vector<double>& other) {
    return one.size() == other.size() &&
           std::memcmp(one.data(), other.data(), one.size() * sizeof(double)) == 0;
  }

  std::vector<std::vector<double>> all_;
  std::unordered_multimap<std::size_t, std::size_t> places_;
};

/// Goes once through all sums.
class Cursor {
 public:
  Cursor(const int* slots, double* x) : slots_(slots), x_(x) {}

  template <class Vector>
  void advance(const double* values, int slot, int columns) noexcept {
    constexpr bool kInLanes = !std::is_same_v<Vector, double>;
    values_ = values;
    double* to = x_ + slot;
    const auto right = add<Vector>(load<Vector>(to), columns, [this](int c) { return x_[slots_[c]]; });
    slots_ += columns;
    if constexpr (kInLanes) {
      store(right, to);  // to be read one by one
      store(add<Vector>(spread<Vector>(0.0), Lanes::kCount, [to](int c) { return to[c]; }), to);
    } else {
      store(right * *values_++, to);
    }
  }

 private:
  template <class Vector, class Factor>
  Vector add(Vector start, int columns, Factor factor) noexcept {
    constexpr bool kInLanes = !std::is_same_v<Vector, double>;
    constexpr int kWidth = kInLanes ? Lanes::kCount : 1, kTogether = static_cast<int>(kSums);
    const auto term = [&](int c, Vector sum) {
      return fused_multiply_add(load<Vector>(values_ + c * kWidth), spread<Vector>(factor(c)), sum);
    };
    Vector a = start, b = spread<Vector>(0.0), c = b, d = b;
    int i = 0;
    for (; i + kTogether <= columns; i += kTogether)
      a = term(i, a), b = term(i + 1, b), c = term(i + 2, c), d = term(i + 3, d);
    if constexpr (!kInLanes)
      for (; i < columns; ++i) a = term(i, a);
    values_ += columns * kWidth;
    return (a + b) + (c + d);
  }

  const double* values_ = nullptr;
  const int* slots_;
  double* x_;
};

}  // namespace

std::vector<int> outer_columns(const Sparse& rows, const Strip& strip) {
  std::vector<int> columns;
  each_entry(rows, strip, [&](int, int column, double) {
    if (!inside(column, strip)) columns.push_back(column);
  });
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  return columns;
}

std::vector<Strip> TriangularSweep::schedule(const Sparse& rows, const std::vector<Strip>& strips) {
  const Places places(static_cast<int>(rows.cols()), strips);
  auto scheduled = strips;
  for (auto& strip : scheduled) {
    strip.level = 0;
    for (const int column : outer_columns(rows, strip))
      strip.level = std::max(strip.level, scheduled[index(places.strip[index(column)])].level + 1);
  }
  std::stable_sort(scheduled.begin(), scheduled.end(),
                   [](const Strip& a, const Strip& b) { return a.level < b.level; });
  return scheduled;
}

/// What there is to do for a strip.
struct TriangularSweep::Work {
  Strip strip;
  std::vector<int> slots;
  std::size_t values;  ///< which: alike where they are the same

  /// Of a level those of the same kind and length together, so that a processor foresees how they go, and
  /// those with the same numbers, so that it still has them at hand.
  auto key() const { return std::tuple(strip.level, strip.in_lanes, slots.size(), values); }
};

TriangularSweep::TriangularSweep(const Sparse& rows, const std::vector<Strip>& strips) {
  const Places places(static_cast<int>(rows.cols()), strips);
  std::vector<int> place(index(rows.cols()));
  DistinctLists lists;
  std::vector<Work> works;
  for (const auto& strip : strips) {
    auto columns = outer_columns(rows, strip);
    // What was solved for last comes last: it need not be there before it is needed.
    std::stable_sort(columns.begin(), columns.end(),
                     [&](int a, int b) { return places.strip[index(a)] < places.strip[index(b)]; });
    const auto width = index(strip.slots()), count = padded(columns.size(), strip);
    std::vector<int> slots(count, strip.slot);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      place[index(columns[c])] = static_cast<int>(c);
      slots[c] = places.slot[index(columns[c])];
    }
    std::vector<double> values(width * count);
    each_entry(rows, strip, [&](int row, int column, double value) {
      if (!inside(column, strip))
        values[width * index(place[index(column)]) + index(row - strip.first)] = -value;
    });
    const auto inverse = inverse_of(rows, strip);
    values.insert(values.end(), inverse.data(), inverse.data() + width * width);
    works.push_back({strip, std::move(slots), lists.find(std::move(values))});
  }
  std::stable_sort(works.begin(), works.end(),
                   [](const Work& a, const Work& b) { return a.key() < b.key(); });
  // Into the memory in the order in which they are first read.
  constexpr auto kNowhere = static_cast<std::size_t>(-1);
  std::vector<std::size_t> begins(lists.all().size(), kNowhere);
  for (const auto& work : works) {
    if (begins[work.values] == kNowhere)
      begins[work.values] = append(lists.all()[work.values], index(work.strip.slots()));
    append(work, begins[work.values]);
  }
}

std::size_t TriangularSweep::append(const std::vector<double>& values, std::size_t alignment) {
  const auto begin = (values_.size() + alignment - 1) / alignment * alignment;
  values_.resize(begin);
  values_.insert(values_.end(), values.begin(), values.end());
  return begin;
}

void TriangularSweep::append(const Work& work, std::size_t values) {
  sums_.push_back({work.strip.slot, static_cast<int>(work.slots.size()), values});
  slots_.insert(slots_.end(), work.slots.begin(), work.slots.end());
  if (runs_.empty() || runs_.back().in_lanes != work.strip.in_lanes)
    runs_.push_back({work.strip.in_lanes, 0});
  runs_.back().end = sums_.size();
}

void TriangularSweep::solve(double* x) const noexcept {
  Cursor cursor(slots_.data(), x);
  const Sum* sum = sums_.data();
  for (const auto& run : runs_) {
    const Sum* end = sums_.data() + run.end;
    if (run.in_lanes)
      for (; sum != end; ++sum) cursor.advance<Lanes>(values_.data() + sum->values, sum->slot, sum->columns);
    else
      for (; sum != end; ++sum) cursor.advance<double>(values_.data() + sum->values, sum->slot, sum->columns);
  }
}

}  // namespace tactus
