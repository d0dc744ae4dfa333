#pragma once
// Thread: [control]

#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/notes.h"
#include "engine/plot/plot.h"

namespace tactus::plot {

// ---- axes

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

// ---- labels

/// [px] An estimate that is rather too wide than too narrow, since the reader's font is not known.
double text_width(std::string_view text, double font_size);

/// Lines of at most `width` pixels, broken at spaces.
std::vector<std::string> wrap(const std::string& text, double font_size, double width);

/// Moves labels apart: each as near to its preferred place as possible, at least `gap` from the next, all
/// within [low, high] as long as there is room. Keeps the order of the vector.
std::vector<double> spread(const std::vector<double>& preferred, double gap, double low, double high);

/// Rows for labels that are centred on `x` and may not overlap: row 0 is the lowest; -1: no room in `rows`.
struct RowLabel {
  double x;  ///< centre; moved so that the label lies within the limits
  double width;
  int row = -1;
  std::string text = {};
  PlotColor color = PlotColor::Black;
};
void place_in_rows(std::vector<RowLabel>& labels, int rows, double low, double high);

struct Point {
  double x, y;
};
/// Pixels of a series in drawing order, cut where a value cannot be shown. Where more than four points share
/// a pixel column, its first, lowest, highest and last stay.
std::vector<std::vector<Point>> polylines(const PlotSeries& series, const Scale& x, const Scale& y);

/// Finds free places for the labels of points.
class FreeSpace {
 public:
  struct Box {
    double left, top, right, bottom;
  };
  explicit FreeSpace(const Box& plot) : plot_(plot) {}

  void take(const Box& box) { taken_.push_back(box); }
  void take(const std::vector<Point>& line);

  struct Place {
    double x, y;  ///< of the anchor, on the base line
    const char* anchor;
  };
  /// Right of the point if that is free, else left, above, below, or at a corner; right if none is. The place
  /// is taken from then on.
  Place beside(const Point& point, double width);

 private:
  Box plot_;
  std::vector<Box> taken_;
};

// ---- a subplot

// [px]: labels, a line of them, a sample in the legend
inline constexpr double kFont = 11.5, kLabelRow = 14, kSample = 26;

/// The least and the largest value that an axis can show.
class Extent {
 public:
  explicit Extent(const PlotAxis& axis) : axis_(axis) {}
  void add(double value) {
    if (!std::isfinite(value) || (axis_.log && value <= 0)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  Range range(bool margin) const { return range_of(axis_, low_, high_, margin); }

 private:
  const PlotAxis& axis_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
};

/// The range of x that all subplots of a plot share.
Range x_range(const Plot& plot);

struct Axis {
  Scale scale;
  PrefixedUnit unit;
  std::vector<Tick> ticks;
};

Axis make_axis(const PlotAxis& axis, const Range& range, double pixel_low, double pixel_high,
               double per_tick);
/// One tick for each name of a column or a row, as many as there is room for.
Axis make_axis(const std::vector<std::string>& names, double pixel_low, double pixel_high, double per_tick);

double widest(const std::vector<std::string>& texts);
/// The colour of a series of a subplot.
PlotColor color_of(const Subplot& subplot, std::size_t series);

/// A label right of a subplot: in its colour at the end of its series, or a line of the legend.
struct Key {
  std::vector<std::string> lines;
  PlotColor color = PlotColor::Black;
  const PlotSeries* series = nullptr;
  const PlotMap::Cell* cell = nullptr;
  Point end = {0, 0};  ///< of what it names: data
};

/// The position of a subplot, its axis and its labels; y is 0 at its upper edge.
class Layout {
 public:
  Layout(const Plot& plot, const Subplot& of, const Range& xs);

  double key_width() const;
  double legend_height() const;

  const Subplot* subplot;
  Range y_values;
  double height = 0, top = 0;
  Axis y;
  std::vector<Key> keys;
  bool legend = false;  ///< samples beside the names, instead of names at the ends of the series
  std::vector<RowLabel> event_labels;  ///< above the subplot
  int event_rows = 0;

 private:
  void add_keys(const Plot& plot, const Range& xs);
};

}  // namespace tactus::plot
