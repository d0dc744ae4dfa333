#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"

// Thread: [control]

namespace tactus {

/// Colours that remain distinguishable for colour-blind readers and in print (after Okabe and Ito, "Color
/// universal design", 2008). Auto takes the next one. A picture follows the reader's light or dark theme.
enum class PlotColor { Auto, Blue, Vermillion, Green, Purple, Orange, Sky, Grey, Black };

enum class PlotMark { Line, Points, LineAndPoints };

/// Values over x. A NaN leaves a gap. Of a dense line each pixel column keeps its lowest and highest value,
/// so a spike of one sample stays visible.
struct PlotSeries {
  std::string label = {};  ///< at its right end, or in the legend; empty: none
  std::vector<double> x = {}, y = {};
  PlotMark mark = PlotMark::Line;
  PlotColor color = PlotColor::Auto;
  bool dashed = false;

  void add(double at, double value) {
    x.push_back(at);
    y.push_back(value);
  }
};

/// The area between two curves over x, in rising order: one side of a border, a band of uncertainty. Where
/// `low` or `high` is empty it reaches to that edge of the plot.
struct PlotRegion {
  std::string label = {};
  std::vector<double> x = {}, low = {}, high = {};
  PlotColor color = PlotColor::Sky;
};

/// A point with its name beside it.
struct PlotPin {
  double x, y;
  std::string label = {};
  PlotColor color = PlotColor::Black;
};

/// A horizontal line: a threshold, a limit.
struct PlotLevel {
  double y;
  std::string label = {};
  PlotColor color = PlotColor::Grey;
};

/// A vertical line with its label on top. Labels that do not fit in three rows are left out.
struct PlotEvent {
  double x;
  std::string label = {};
  PlotColor color = PlotColor::Grey;
};

/// A shaded range of x.
struct PlotBand {
  double from, to;
  std::string label = {};
  PlotColor color = PlotColor::Sky;
};

/// Coloured cells over two named axes; column 0 is the left one, row 0 the lowest.
struct PlotMap {
  /// A colour of the palette, or a share of the colour ramp (cividis of Nunez, Anderton and Renslow, PLoS ONE
  /// 13, 2018). A share of NaN is an empty cell.
  struct Cell {
    PlotColor color = PlotColor::Auto;
    double share = std::numeric_limits<double>::quiet_NaN();
    std::string letter = {};  ///< at most two characters
  };
  struct Key {
    Cell cell;
    std::string label;
  };
  std::vector<std::string> columns, rows;
  std::vector<Cell> cells;  ///< row by row: cells[row * columns.size() + column]
  std::vector<Key> keys;    ///< legend
};
/// A map of values, coloured from the least to the largest (or between the limits, where given).
PlotMap value_map(std::vector<std::string> columns, std::vector<std::string> rows,
                  const std::vector<double>& values, std::optional<double> low = {},
                  std::optional<double> high = {});

struct PlotAxis {
  std::string label = {};
  /// SI, as in graph files: "m", "N/m", "Hz"; data are in it. The axis picks the prefix. "" and "dB" stay as
  /// they are.
  std::string unit = {};
  std::optional<double> low = {}, high = {};  ///< SI; left out: from the data
  bool log = false;                           ///< only positive values are shown
  bool notes = false;                         ///< of pitch, in Hz and log: ticks at notes of the scale
};

struct Subplot {
  PlotAxis y = {};  ///< its label is above the subplot
  std::vector<PlotSeries> series = {};
  std::vector<PlotLevel> levels = {};
  std::vector<PlotEvent> events = {};  ///< of this subplot only
  std::vector<PlotBand> bands = {};
  std::vector<PlotRegion> regions = {};
  std::vector<PlotPin> pins = {};
  std::optional<PlotMap> map = {};  ///< replaces both axes
  double height = 1.0;              ///< relative to the others
};

/// Subplots above one another with one x axis.
struct Plot {
  std::string title = {};
  std::string subtitle = {};
  PlotAxis x = {};
  std::vector<Subplot> subplots = {};
  std::vector<PlotEvent> events = {};  ///< through all subplots
  int width = 900;                     ///< [px]
  int subplot_height = 130;            ///< of a subplot of height 1 [px]
};

/// A trace of samples `step` apart, the first at `start`.
PlotSeries plot_trace(std::string label, double start, double step, std::vector<double> values);

/// A page of plots as an SVG document, in `columns` columns.
std::string to_svg(const std::vector<Plot>& page, int columns = 1);
/// Errors: BadFile.
[[nodiscard]] Status write_svg(const std::filesystem::path& path, const std::vector<Plot>& page,
                               int columns = 1);

}  // namespace tactus
