#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "engine/core/notes.h"
#include "engine/plot/plot.h"

// Thread: [any]

namespace tactus {

namespace plot {

struct Range {
  double low, high;
};

/// From data to pixels, linear or logarithmic.
struct Scale {
  double low, high;              ///< data
  double pixel_low, pixel_high;  ///< their pixels; pixel_high < pixel_low for y
  bool log = false;

  double pixel(double value) const {
    const double share = log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return pixel_low + share * (pixel_high - pixel_low);
  }
  bool shows(double value) const { return std::isfinite(value) && (!log || value > 0.0); }
  bool contains(double value) const { return shows(value) && value >= low && value <= high; }
};

/// The range of an axis for data between `low` and `high`: the limits of the axis, or the data with a margin
/// of 6 % at each end (`margin` false: none).
Range range_of(const PlotAxis& axis, double low, double high, bool margin);

/// SI prefix of an axis: "mm" and 1e-3 for "m" at a few millimetres.
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
/// 5 where there are fewer than two of those, or else, within a decade, as on a linear scale. `axis.notes`:
/// at notes, "A3 220 Hz".
std::vector<Tick> ticks_of(const Scale& scale, const PlotAxis& axis, const PrefixedUnit& prefixed, int most);

/// "label [mm]"; on a log axis the ticks carry the unit.
std::string axis_title(const PlotAxis& axis, const PrefixedUnit& prefixed);

}  // namespace plot
}  // namespace tactus
