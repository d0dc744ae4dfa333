#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/plot/svg_scale.h"

namespace tactus::svg {

/// [px] An estimate that is rather too wide than too narrow, since the reader's font is not known.
double text_width(std::string_view text, double font_size);

/// Lines of at most `width` pixels, broken at spaces.
std::vector<std::string> wrap(const std::string& text, double font_size, double width);

/// Moves labels apart: each as near to where it wants to be as it goes, at least `gap` from the next, all
/// within [low, high] as long as there is room. Keeps the order of the vector.
std::vector<double> spread(const std::vector<double>& wanted, double gap, double low, double high);

/// Rows for labels that are centred on `x` and may not overlap: row 0 is the lowest. -1: found no room in
/// `rows`.
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

}  // namespace tactus::svg
