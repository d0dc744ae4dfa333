#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "engine/plot/svg.h"

namespace tactus::svg {

/// Between data and pixels, straight or logarithmic.
struct Scale {
  double low, high;              ///< data
  double pixel_low, pixel_high;  ///< where they lie; pixel_high < pixel_low for y
  bool log = false;

  double pixel(double value) const {
    const double part = log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return pixel_low + part * (pixel_high - pixel_low);
  }
  bool shows(double value) const { return std::isfinite(value) && (!log || value > 0.0); }
};

/// The range of an axis for data between `low` and `high`: asked for, or with a margin of 6 % at each end
/// (`margin` false: none).
struct Range {
  double low, high;
};
Range range_of(const PlotAxis& axis, double low, double high, bool margin);

/// SI prefix by which an axis is written: "mm" and 1e-3 for "m" at a few millimetres.
struct PrefixedUnit {
  std::string text;
  double factor = 1.0;
};
PrefixedUnit prefixed_unit(const std::string& unit, double largest);

struct Tick {
  double value;  ///< SI
  std::string text;
};
/// At most about `most` ticks at 1, 2 or 5 times a power of ten; on a log scale at powers of ten, or at 1, 2,
/// 5 where fewer than two of those are there, or else, within a decade, as on a straight one. `unit` is how
/// the numbers are written.
std::vector<Tick> ticks_of(const Scale& scale, const std::string& unit, const PrefixedUnit& prefixed,
                           int most);

/// "label [mm]"; on a log axis the ticks carry the unit.
std::string axis_title(const PlotAxis& axis, const PrefixedUnit& prefixed);

}  // namespace tactus::svg
