#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/plot/axis.h"

// Thread: [any]

namespace tactus::plot {

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

}  // namespace tactus::plot
