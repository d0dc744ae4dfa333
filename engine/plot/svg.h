#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// Colours that stay apart for colour-blind eyes and on paper (after Okabe and Ito, "Color universal design",
/// 2008; darkened where they are used for text). Auto takes the next one.
enum class PlotColor { Auto, Blue, Vermillion, Green, Purple, Orange, Sky, Grey, Black };

enum class PlotMark { Line, Points, LineAndPoints, Stems };

/// Values over x. Lines and stems need x in rising order; a NaN leaves a gap. Of a dense line each pixel
/// column keeps its lowest and highest value, so a spike of one sample stays visible.
struct PlotSeries {
  std::string label = {};  ///< stands at its right end in its colour; empty: none
  std::vector<double> x = {}, y = {};
  PlotMark mark = PlotMark::Line;
  PlotColor color = PlotColor::Auto;
  bool dashed = false;
};

/// A horizontal line: a threshold, a limit.
struct PlotLevel {
  double y;
  std::string label = {};
  PlotColor color = PlotColor::Grey;
};

/// A moment: a vertical line with its label on top. Labels that find no room in three rows are left out.
struct PlotEvent {
  double x;
  std::string label = {};
  PlotColor color = PlotColor::Grey;
};

/// A stretch of time, shaded.
struct PlotSpan {
  double from, to;
  std::string label = {};
  PlotColor color = PlotColor::Sky;
};

struct PlotAxis {
  std::string label = {};
  /// SI, as in graph files: "m", "N/m", "Hz"; data are in it. The axis picks the prefix. "" and "dB" stay as
  /// is.
  std::string unit = {};
  std::optional<double> low = {}, high = {};  ///< SI; left out: from the data
  bool log = false;                           ///< only positive values are shown
  bool notes = false;                         ///< of pitch, in Hz and log: ticks at notes of the scale
};

struct PlotPanel {
  PlotAxis y = {};  ///< its label stands above the panel
  std::vector<PlotSeries> series = {};
  std::vector<PlotLevel> levels = {};
  std::vector<PlotEvent> events = {};  ///< of this panel only
  std::vector<PlotSpan> spans = {};
  double height = 1.0;  ///< relative to the others
};

/// Panels on top of each other with one x axis.
struct Figure {
  std::string title = {};
  std::string subtitle = {};
  PlotAxis x = {};
  std::vector<PlotPanel> panels = {};
  std::vector<PlotEvent> events = {};  ///< through all panels
  std::vector<PlotSpan> spans = {};
  int width = 900;         ///< [px]
  int panel_height = 130;  ///< of a panel of height 1 [px]
};

/// [control] A trace of samples `step` apart, the first at `start`.
PlotSeries plot_trace(std::string label, double start, double step, std::vector<double> values);

/// [control] The figure, or a page of figures below one another, as an SVG document on white ground.
std::string to_svg(const Figure& figure);
std::string to_svg_page(const std::vector<Figure>& page);

/// [control] Errors: BadFile.
[[nodiscard]] Status write_svg(const std::filesystem::path& path, const Figure& figure);
[[nodiscard]] Status write_svg_page(const std::filesystem::path& path, const std::vector<Figure>& page);

}  // namespace tactus
