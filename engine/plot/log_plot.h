#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/plot/svg.h"

namespace tactus {

/// What lies between two curves over x, filled: a side of a border, a band of uncertainty. Where `low` or
/// `high` is empty it reaches to that edge of the plot. x in rising order.
struct PlotRegion {
  std::string label = {};  ///< in the legend; empty: none
  std::vector<double> x = {}, low = {}, high = {};
  PlotColor color = PlotColor::Sky;
};

/// One point with its name beside it: a device on a map, a working point.
struct PlotPin {
  double x, y;
  std::string label = {};
  PlotColor color = PlotColor::Black;
};

/// A map of one quantity against another, both over decades unless an axis says `log = false`: named curves
/// (lines, points or both) with a legend on the right, filled regions below them, named points above them.
/// Values that an axis cannot show (not finite; on a log axis not positive) leave a gap. The labels of `pins`
/// are put where they cover no curve, no other pin and no other label, as far as there is such a place.
struct LogPlot {
  std::string title = {};
  std::string subtitle = {};
  PlotAxis x = {.log = true};
  PlotAxis y = {.log = true};  ///< its label stands above the plot
  std::vector<PlotRegion> regions = {};
  std::vector<PlotSeries> series = {};
  std::vector<PlotPin> pins = {};
  int width = 900, height = 420;  ///< [px] with the legend, and of the plot alone
};

/// [control] A page of plots below one another as an SVG document on white ground.
std::string log_plots_svg(const std::vector<LogPlot>& page);

/// [control] The same into a file. Errors: BadFile.
[[nodiscard]] Status write_log_plots(const std::filesystem::path& path, const std::vector<LogPlot>& page);

}  // namespace tactus
