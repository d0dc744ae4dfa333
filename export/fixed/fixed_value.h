#pragma once

// Thread: [any].

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "engine/graph/semantics/interval.h"

namespace tactus {

/// A signal as an integer. A word has as many bits as the numbers of the program, a wide one twice as many:
/// products, and what only limits read.
struct FixedValue {
  std::string text = {};    ///< a C operand; of a constant not used
  int exponent = 0;         ///< value = integer * 2^-exponent
  Interval range = {0, 0};  ///< of the value, with what rounding adds: what no overflow is deduced from
  double error = 0;         ///< largest distance from the same graph in exact numbers
  bool wide = false;
  bool flag = false;  ///< 0 or 1; exponent 0
  std::optional<double> constant = {};

  double step() const { return std::ldexp(1.0, -exponent); }
  double size() const { return std::max(std::abs(range.low), std::abs(range.high)); }
};

inline Interval widened_by(Interval range, double by) { return {range.low - by, range.high + by}; }

}  // namespace tactus
