#include "engine/plot/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <utility>

#include "engine/plot/labels.h"

namespace tactus {
namespace {

using namespace plot;

constexpr double kFont = 11.5, kTitleFont = 17, kSubtitleFont = 12.5;  // [px]
constexpr double kTitleRow = 22, kSubtitleRow = 17, kLabelRow = 14;
constexpr double kPad = 16;                        // around a plot
constexpr double kSample = 26, kLegendText = 200;  // of a line of the legend
constexpr double kWidestCell = 40, kHighestCell = 24, kHighestMap = 480;
constexpr int kEventRows = 3;

/// A colour of lines and areas, and of text, in the light and in the dark theme.
struct Shade {
  const char *line, *text, *dark_line, *dark_text;
};
constexpr std::array<Shade, 9> kShades = {{{"none", "none", "none", "none"},
                                           {"#0072b2", "#00609a", "#3a9fe0", "#6bb8ea"},
                                           {"#d55e00", "#b34700", "#ef7d2b", "#f59a58"},
                                           {"#009e73", "#007a58", "#1fbf92", "#45d0a8"},
                                           {"#b0609a", "#974a82", "#cc84b9", "#dba2cb"},
                                           {"#e69f00", "#8f6200", "#e9ad2b", "#f0c361"},
                                           {"#56b4e9", "#1f7db5", "#56b4e9", "#83c8ef"},
                                           {"#8a8a8a", "#5f5f5f", "#8f8f8f", "#b0b0b0"},
                                           {"#222222", "#222222", "#e6e6e6", "#e6e6e6"}}};
/// Everything that is not data.
struct Theme {
  const char *page, *ink, *soft, *grid, *zero, *axis;
};
constexpr Theme kLight = {"#ffffff", "#222222", "#5f5f5f", "#e6e6e6", "#bdbdbd", "#8a8a8a"};
constexpr Theme kDark = {"#1b1b1b", "#e6e6e6", "#b0b0b0", "#353535", "#5a5a5a", "#8f8f8f"};

std::string rules(const Theme& theme, bool dark) {
  auto text = fmt::format(
      ".page,.gap{{fill:{0}}}.gap,.dot{{stroke:{0}}}.ink{{fill:{1}}}.soft{{fill:{2}}}.grid{{stroke:{3}}}"
      ".zero{{stroke:{4}}}.axis{{stroke:{5}}}\n",
      theme.page, theme.ink, theme.soft, theme.grid, theme.zero, theme.axis);
  for (std::size_t i = 1; i < kShades.size(); ++i)
    text += fmt::format(".s{0}{{stroke:{1}}}.f{0}{{fill:{1}}}.t{0}{{fill:{2}}}\n", i,
                        dark ? kShades[i].dark_line : kShades[i].line,
                        dark ? kShades[i].dark_text : kShades[i].text);
  return text;
}

/// Safe between tags.
std::string escape(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '"')
      safe += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      safe += c;
  }
  return safe;
}

std::string ramp_color(double share) {
  using Color = std::array<double, 3>;
  static constexpr std::array<Color, 6> kCividis = {
      {{0, 32, 76}, {49, 68, 107}, {102, 105, 112}, {149, 143, 120}, {202, 185, 105}, {255, 234, 70}}};
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kCividis.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(place), kCividis.size() - 2);
  const double part = place - static_cast<double>(low);
  const auto mix = [&](std::size_t channel) {
    const double from = kCividis[low][channel], to = kCividis[low + 1][channel];
    return static_cast<int>(std::lround(from + part * (to - from)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2));
}

/// The class of an element, "s" for strokes, "f" for areas, "t" for text.
std::string css(char kind, PlotColor color) { return fmt::format("{}{}", kind, static_cast<int>(color)); }

/// The text of an SVG document, element after element.
class Canvas {
 public:
  template <class... Args>
  void out(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  void line(const Point& a, const Point& b, const std::string& css, double width = 1, const char* more = "") {
    out("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\" "
        "stroke-width=\"{}\"{}/>\n",
        a.x, a.y, b.x, b.y, css, width, more);
  }
  void text(double x, double y, const std::string& text, const char* anchor, const std::string& css,
            double size = kFont, bool bold = false) {
    out("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" class=\"{}\"", x, y, anchor, css);
    if (size != kFont) out(" font-size=\"{}\"", size);
    out("{}>{}</text>\n", bold ? " font-weight=\"bold\"" : "", escape(text));
  }
  void rect(double x, double y, double width, double height, const std::string& attributes) {
    out("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}/>\n", x, y, width, height,
        attributes);
  }
  void path(const std::vector<Point>& line, PlotColor color, bool dashed) {
    out("<path fill=\"none\" class=\"{}\" stroke-width=\"1.6\" stroke-linejoin=\"round\"{} d=\"",
        css('s', color), dashed ? " stroke-dasharray=\"5 3\"" : "");
    for (std::size_t i = 0; i < line.size(); ++i)
      out("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", line[i].x, line[i].y);
    out("\"/>\n");
  }
  void dot(const Point& at, PlotColor color) {
    out("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" class=\"{} dot\" stroke-width=\"0.8\"/>\n", at.x, at.y,
        css('f', color));
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

double widest(const std::vector<std::string>& texts) {
  double most = 0;
  for (const auto& text : texts) most = std::max(most, text_width(text, kFont));
  return most;
}

PlotColor color_of(const Subplot& subplot, std::size_t series) {
  const auto chosen = subplot.series[series].color;
  return chosen != PlotColor::Auto ? chosen : static_cast<PlotColor>(1 + series % 6);
}

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

Range x_range(const Plot& plot) {
  Extent extent{plot.x};
  bool margin = false;
  for (const auto& subplot : plot.subplots) {
    if (subplot.map) return {0, static_cast<double>(std::max<std::size_t>(1, subplot.map->columns.size()))};
    for (const auto& series : subplot.series) {
      margin = margin || series.mark != PlotMark::Line;
      for (const double x : series.x) extent.add(x);
    }
    for (const auto& region : subplot.regions)
      for (const double x : region.x) extent.add(x);
    for (const auto& pin : subplot.pins) extent.add(pin.x), margin = true;
  }
  return extent.range(margin);
}

Range y_range(const Subplot& subplot, const Range& x) {
  if (subplot.map) return {0, static_cast<double>(std::max<std::size_t>(1, subplot.map->rows.size()))};
  Extent extent{subplot.y};
  for (const auto& series : subplot.series)
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i)
      if (series.x[i] >= x.low && series.x[i] <= x.high) extent.add(series.y[i]);
  for (const auto& level : subplot.levels) extent.add(level.y);
  for (const auto& pin : subplot.pins) extent.add(pin.y);
  return extent.range(true);
}

struct Axis {
  Scale scale;
  PrefixedUnit unit;
  std::vector<Tick> ticks;
};

Axis make_axis(const PlotAxis& axis, const Range& range, double pixel_low, double pixel_high,
               double per_tick) {
  Axis made;
  made.scale = {range.low, range.high, pixel_low, pixel_high, axis.log};
  made.unit = prefixed_unit(axis.unit, std::max(std::abs(range.low), std::abs(range.high)));
  made.ticks =
      ticks_of(made.scale, axis, made.unit, static_cast<int>(std::abs(pixel_high - pixel_low) / per_tick));
  return made;
}

/// One tick for each name of a column or a row, as many as there is room for.
Axis make_axis(const std::vector<std::string>& names, double pixel_low, double pixel_high, double per_tick) {
  const auto count = static_cast<double>(std::max<std::size_t>(1, names.size()));
  Axis made{{0, count, pixel_low, pixel_high}, {}, {}};
  const auto every = static_cast<std::size_t>(
      std::max(1.0, std::ceil(per_tick * count / std::max(1.0, std::abs(pixel_high - pixel_low)))));
  for (std::size_t i = 0; i < names.size(); i += every)
    made.ticks.push_back({static_cast<double>(i) + 0.5, names[i]});
  return made;
}

/// A label right of a subplot: in its colour at the end of its series, or a line of the legend.
struct Key {
  std::vector<std::string> lines;
  PlotColor color = PlotColor::Black;
  const PlotSeries* series = nullptr;
  const PlotMap::Cell* cell = nullptr;
  Point end = {0, 0};  ///< of what it names, in shares of the axes
};

/// The last point that is shown, in shares of the axes.
std::optional<Point> end_of(const PlotSeries& series, const Range& xs, const Range& ys, const Plot& plot,
                            const Subplot& subplot) {
  const Scale x{xs.low, xs.high, 0, 1, plot.x.log}, y{ys.low, ys.high, 0, 1, subplot.y.log};
  for (auto n = std::min(series.x.size(), series.y.size()); n-- > 0;)
    if (x.shows(series.x[n]) && y.shows(series.y[n]) && series.x[n] <= x.high)
      return Point{x.pixel(series.x[n]), std::clamp(y.pixel(series.y[n]), 0.0, 1.0)};
  return std::nullopt;
}

/// Where a subplot lies; y is 0 at its upper edge.
struct Layout {
  Layout(const Plot& plot, const Subplot& of, const Range& xs) : subplot(&of), y_values(y_range(of, xs)) {
    if (of.map) {
      const auto rows = static_cast<double>(of.map->rows.size());
      height = rows * std::clamp(kHighestMap / std::max(1.0, rows), 2.0, kHighestCell);
      y = make_axis(of.map->rows, height, 0, kLabelRow);
    } else {
      height = of.height * plot.subplot_height;
      y = make_axis(of.y, y_values, height, 0, height < 200 ? 26 : 30);
    }
    add_keys(plot, xs);
  }

  void add_keys(const Plot& plot, const Range& xs);
  double key_width() const {
    double most = 0;
    for (const auto& key : keys) most = std::max(most, widest(key.lines));
    return keys.empty() ? 0 : most + 14 + (legend ? kSample + 6 : 0);
  }
  double legend_height() const {
    double rows = 0;
    for (const auto& key : keys) rows += kLabelRow * static_cast<double>(key.lines.size()) + 4;
    return legend ? rows : 0;
  }

  const Subplot* subplot;
  Range y_values;
  double height = 0, top = 0;
  Axis y;
  std::vector<Key> keys;
  bool legend = false;  ///< samples beside the names, instead of names at the ends of the series
  std::vector<RowLabel> event_labels;  ///< above the subplot
  std::vector<std::pair<std::string, PlotColor>> event_texts;
};

void Layout::add_keys(const Plot& plot, const Range& xs) {
  constexpr double kNearEdge = 0.85;
  const auto add = [&](const std::string& label, PlotColor color) -> Key& {
    keys.push_back({wrap(label, kFont, kLegendText), color});
    return keys.back();
  };
  for (std::size_t i = 0; i < subplot->series.size(); ++i) {
    const auto& series = subplot->series[i];
    const auto end = end_of(series, xs, y_values, plot, *subplot);
    if (series.label.empty() || !end) continue;
    auto& key = add(series.label, color_of(*subplot, i));
    key.series = &series;
    key.end = *end;
    // A leader from a series that ends early would cross the others; a cloud of points has no end.
    legend = legend || end->x < kNearEdge || (series.mark == PlotMark::Points && height > 200);
  }
  for (const auto& level : subplot->levels)
    if (!level.label.empty()) add(level.label, level.color).end = {1, y.scale.pixel(level.y) / -height + 1};
  for (const auto& region : subplot->regions)
    if (!region.label.empty()) add(region.label, region.color), legend = true;
  if (subplot->map)
    for (const auto& entry : subplot->map->keys)
      add(entry.label, PlotColor::Black).cell = &entry.cell, legend = true;
  legend = legend || kLabelRow * static_cast<double>(keys.size()) > height;
}

class Drawing {
 public:
  /// `id`: a prefix for the clip paths, unique on the page.
  Drawing(const Plot& plot, Canvas& canvas, std::string id);

  double height() const { return height_; }
  void draw() {
    draw_header();
    for (std::size_t i = 0; i < layouts_.size(); ++i) {
      canvas_.out("<g transform=\"translate(0 {:.1f})\">\n", layouts_[i].top);
      draw_subplot(layouts_[i], fmt::format("{}{}", id_, i));
      canvas_.out("</g>\n");
    }
  }

 private:
  void label_events(Layout& layout, const std::vector<PlotEvent>& events, const std::vector<PlotBand>& bands);
  void draw_header();
  void draw_subplot(const Layout& layout, const std::string& clip);
  void draw_bands(const Layout& layout, const std::vector<PlotBand>& bands);
  void draw_events(const Layout& layout, const std::vector<PlotEvent>& events);
  void draw_region(const Layout& layout, const PlotRegion& region);
  void draw_grid(const Layout& layout);
  void draw_series(const Layout& layout, const PlotSeries& series, PlotColor color);
  void draw_map(const Layout& layout);
  void draw_pins(const Layout& layout);
  void draw_cell(double x, double y, double width, double height, const PlotMap::Cell& cell);
  void draw_end_labels(const Layout& layout);
  void draw_legend(const Layout& layout);
  void draw_x_axis(const Layout& layout);

  const Plot& plot_;
  Canvas& canvas_;
  std::string id_;
  std::vector<std::string> title_, subtitle_;
  double left_ = kPad, right_, height_;
  Axis x_;
  std::vector<Layout> layouts_;
};

Drawing::Drawing(const Plot& plot, Canvas& canvas, std::string id)
    : plot_(plot), canvas_(canvas), id_(std::move(id)), right_(plot.width - kPad) {
  title_ = wrap(plot.title, kTitleFont, plot.width - 2 * kPad);
  subtitle_ = wrap(plot.subtitle, kSubtitleFont, plot.width - 2 * kPad);
  const auto range = x_range(plot);
  double ticks = 0, keys = 0;
  for (const auto& subplot : plot.subplots) {
    const auto& layout = layouts_.emplace_back(plot, subplot, range);
    for (const auto& tick : layout.y.ticks) ticks = std::max(ticks, text_width(tick.text, kFont));
    keys = std::max(keys, layout.key_width());
  }
  left_ += ticks + 8;
  right_ -= keys;
  if (!layouts_.empty() && plot.subplots.front().map) {
    const auto& columns = plot.subplots.front().map->columns;
    right_ = std::min(right_, left_ + kWidestCell * static_cast<double>(columns.size()));
    x_ = make_axis(columns, left_, right_, widest(columns) + 4);
  } else {
    x_ = make_axis(plot.x, range, left_, right_, 80);
  }
  height_ = kPad + kTitleRow * static_cast<double>(title_.size()) +
            kSubtitleRow * static_cast<double>(subtitle_.size()) + 4;
  for (auto& layout : layouts_) {
    // Events of the whole plot are named once, at the top.
    if (&layout == &layouts_.front()) label_events(layout, plot.events, plot.bands);
    label_events(layout, layout.subplot->events, layout.subplot->bands);
    place_in_rows(layout.event_labels, kEventRows, kPad, plot.width - kPad);
    int rows = 0;
    for (const auto& label : layout.event_labels) rows = std::max(rows, label.row + 1);
    layout.top = height_ + (axis_title(layout.subplot->y, layout.y.unit).empty() ? 6 : 22) + kLabelRow * rows;
    height_ = layout.top + std::max(layout.height + 10, layout.legend_height());
  }
  if (!layouts_.empty()) height_ = std::max(height_, layouts_.back().top + layouts_.back().height + 44);
}

void Drawing::label_events(Layout& layout, const std::vector<PlotEvent>& events,
                           const std::vector<PlotBand>& bands) {
  const auto add = [&](double x, const std::string& text, PlotColor color) {
    if (text.empty() || !x_.scale.contains(x)) return;
    layout.event_labels.push_back({x_.scale.pixel(x), text_width(text, kFont)});
    layout.event_texts.emplace_back(text, color);
  };
  for (const auto& event : events) add(event.x, event.label, event.color);
  for (const auto& band : bands) {
    const double from = std::max(band.from, x_.scale.low), to = std::min(band.to, x_.scale.high);
    add(x_.scale.log ? std::sqrt(from * to) : 0.5 * (from + to), band.label, band.color);
  }
}

void Drawing::draw_header() {
  double y = kPad + 14;
  for (const auto& line : title_) {
    canvas_.text(kPad, y, line, "start", "ink", kTitleFont, true);
    y += kTitleRow;
  }
  for (const auto& line : subtitle_) {
    canvas_.text(kPad, y - 2, line, "start", "soft", kSubtitleFont);
    y += kSubtitleRow;
  }
}

void Drawing::draw_subplot(const Layout& layout, const std::string& clip) {
  const auto& subplot = *layout.subplot;
  draw_bands(layout, plot_.bands);
  draw_bands(layout, subplot.bands);
  if (!subplot.map) draw_grid(layout);
  draw_events(layout, plot_.events);
  draw_events(layout, subplot.events);
  // Room for the points on the edge.
  canvas_.out(
      "<clipPath id=\"{}\"><rect x=\"{:.1f}\" y=\"-4\" width=\"{:.1f}\" height=\"{:.1f}\"/></clipPath>\n",
      clip, left_ - 4, right_ - left_ + 8, layout.height + 8);
  canvas_.out("<g clip-path=\"url(#{})\">\n", clip);
  for (const auto& region : subplot.regions) draw_region(layout, region);
  for (std::size_t i = 0; i < subplot.series.size(); ++i)
    draw_series(layout, subplot.series[i], color_of(subplot, i));
  for (const auto& level : subplot.levels) {
    const double y = layout.y.scale.pixel(level.y);
    canvas_.line({left_, y}, {right_, y}, css('s', level.color), 1.2, " stroke-dasharray=\"7 4\"");
  }
  canvas_.out("</g>\n");
  if (subplot.map) draw_map(layout);
  draw_pins(layout);
  for (const auto& tick : layout.y.ticks)
    canvas_.text(left_ - 6, layout.y.scale.pixel(tick.value) + 4, tick.text, "end", "soft");
  int rows = 0;
  for (std::size_t i = 0; i < layout.event_labels.size(); ++i) {
    const auto& label = layout.event_labels[i];
    rows = std::max(rows, label.row + 1);
    if (label.row >= 0)
      canvas_.text(label.x, -5 - kLabelRow * label.row, layout.event_texts[i].first, "middle",
                   css('t', layout.event_texts[i].second));
  }
  canvas_.text(kPad, -8 - kLabelRow * rows, axis_title(subplot.y, layout.y.unit), "start", "ink",
               kSubtitleFont, true);
  layout.legend ? draw_legend(layout) : draw_end_labels(layout);
  if (&layout == &layouts_.back()) draw_x_axis(layout);
}

void Drawing::draw_bands(const Layout& layout, const std::vector<PlotBand>& bands) {
  for (const auto& band : bands) {
    const auto pixel = [&](double x) {
      return std::clamp(x_.scale.pixel(std::clamp(x, x_.scale.low, x_.scale.high)), left_, right_);
    };
    canvas_.rect(pixel(band.from), 0, std::max(0.0, pixel(band.to) - pixel(band.from)), layout.height,
                 fmt::format("class=\"{}\" opacity=\"0.14\"", css('f', band.color)));
  }
}

void Drawing::draw_events(const Layout& layout, const std::vector<PlotEvent>& events) {
  for (const auto& event : events)
    if (x_.scale.contains(event.x)) {
      const double x = x_.scale.pixel(event.x);
      canvas_.line({x, 0}, {x, layout.height}, css('s', event.color), 1, " stroke-dasharray=\"3 3\"");
    }
}

void Drawing::draw_region(const Layout& layout, const PlotRegion& region) {
  const auto edge = [&](const std::vector<double>& values, std::size_t i, double otherwise) {
    return i < values.size() && layout.y.scale.shows(values[i]) ? layout.y.scale.pixel(values[i]) : otherwise;
  };
  canvas_.out("<path stroke=\"none\" class=\"{}\" opacity=\"0.13\" d=\"", css('f', region.color));
  const char* step = "M";
  for (std::size_t i = 0; i < region.x.size(); ++i, step = "L")
    canvas_.out("{}{:.1f} {:.1f}", step, x_.scale.pixel(region.x[i]), edge(region.high, i, 0));
  for (std::size_t i = region.x.size(); i-- > 0;)
    canvas_.out("L{:.1f} {:.1f}", x_.scale.pixel(region.x[i]), edge(region.low, i, layout.height));
  canvas_.out("Z\"/>\n");
}

void Drawing::draw_grid(const Layout& layout) {
  for (const auto& tick : x_.ticks) {
    const double x = x_.scale.pixel(tick.value);
    canvas_.line({x, 0}, {x, layout.height}, "grid");
  }
  for (const auto& tick : layout.y.ticks) {
    const double y = layout.y.scale.pixel(tick.value);
    canvas_.line({left_, y}, {right_, y}, tick.value == 0.0 && !layout.y.scale.log ? "zero" : "grid");
  }
  canvas_.line({left_, layout.height}, {right_, layout.height}, "axis");
}

void Drawing::draw_series(const Layout& layout, const PlotSeries& series, PlotColor color) {
  const auto &x = x_.scale, &y = layout.y.scale;
  if (series.mark != PlotMark::Points)
    for (const auto& line : polylines(series, x, y)) canvas_.path(line, color, series.dashed);
  if (series.mark == PlotMark::Line) return;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i)
    if (x.shows(series.x[i]) && y.shows(series.y[i]))
      canvas_.dot({x.pixel(series.x[i]), y.pixel(series.y[i])}, color);
}

void Drawing::draw_cell(double x, double y, double width, double height, const PlotMap::Cell& cell) {
  const bool small = height < 8 || width < 8;
  const auto fill = cell.color != PlotColor::Auto ? fmt::format("class=\"{} gap\"", css('f', cell.color))
                    : std::isfinite(cell.share)
                        ? fmt::format("class=\"gap\" style=\"fill:{}\"", ramp_color(cell.share))
                        : std::string{"class=\"page\""};
  canvas_.rect(x, y, width, height, fmt::format("{} stroke-width=\"{}\"", fill, small ? 0.0 : 0.6));
  if (!cell.letter.empty() && width >= 9 && height >= 9)
    canvas_.out(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" fill=\"#ffffff\" "
        "font-size=\"10\">{}</text>\n",
        x + 0.5 * width, y + 0.5 * height + 4, escape(cell.letter));
}

void Drawing::draw_map(const Layout& layout) {
  const auto& map = *layout.subplot->map;
  const auto columns = std::max<std::size_t>(1, map.columns.size());
  const double width = (right_ - left_) / static_cast<double>(columns);
  const double height = layout.height / static_cast<double>(std::max<std::size_t>(1, map.rows.size()));
  for (std::size_t i = 0; i < map.cells.size(); ++i)
    draw_cell(left_ + static_cast<double>(i % columns) * width,
              layout.height - static_cast<double>(i / columns + 1) * height, width, height, map.cells[i]);
}

void Drawing::draw_pins(const Layout& layout) {
  if (layout.subplot->pins.empty()) return;
  FreeSpace space{{left_, 0, right_, layout.height}};
  for (const auto& series : layout.subplot->series)
    for (const auto& line : polylines(series, x_.scale, layout.y.scale)) space.take(line);
  std::vector<const PlotPin*> shown;
  for (const auto& pin : layout.subplot->pins)
    if (x_.scale.contains(pin.x) && layout.y.scale.contains(pin.y)) shown.push_back(&pin);
  for (const auto* pin : shown) {
    const double x = x_.scale.pixel(pin->x), y = layout.y.scale.pixel(pin->y);
    space.take({x - 5, y - 5, x + 5, y + 5});
    canvas_.out("<path d=\"M{:.1f} {:.1f}l5 5l5 -5l-5 -5Z\" class=\"{} dot\"/>\n", x - 5, y,
                css('f', pin->color));
  }
  for (const auto* pin : shown) {
    if (pin->label.empty()) continue;
    const auto place =
        space.beside({x_.scale.pixel(pin->x), layout.y.scale.pixel(pin->y)}, text_width(pin->label, kFont));
    canvas_.text(place.x, place.y, pin->label, place.anchor, css('t', pin->color), kFont, true);
  }
}

void Drawing::draw_end_labels(const Layout& layout) {
  std::vector<double> preferred;
  for (const auto& key : layout.keys) preferred.push_back((1 - key.end.y) * layout.height);
  const auto placed = spread(preferred, kLabelRow, 2, layout.height - 2);
  for (std::size_t i = 0; i < layout.keys.size(); ++i) {
    const auto& key = layout.keys[i];
    const double x = left_ + key.end.x * (right_ - left_);
    canvas_.line({x + 3, preferred[i]}, {right_ + 10, placed[i]}, css('s', key.color), 0.8,
                 " opacity=\"0.6\"");
    std::string text;
    for (const auto& line : key.lines) text += (text.empty() ? "" : " ") + line;
    canvas_.text(right_ + 13, placed[i] + 4, text, "start", css('t', key.color), kFont, true);
  }
}

void Drawing::draw_legend(const Layout& layout) {
  const double left = right_ + 14;
  double y = 10;
  for (const auto& key : layout.keys) {
    const double middle = y - 4;
    if (key.cell != nullptr) {
      draw_cell(left + kSample - 12, middle - 6, 12, 12, {key.cell->color, key.cell->share});
    } else if (key.series == nullptr) {
      canvas_.rect(left, middle - 5, kSample, 10,
                   fmt::format("class=\"{}\" opacity=\"0.25\"", css('f', key.color)));
    } else {
      if (key.series->mark != PlotMark::Points)
        canvas_.path({{left, middle}, {left + kSample, middle}}, key.color, key.series->dashed);
      if (key.series->mark != PlotMark::Line) canvas_.dot({left + 0.5 * kSample, middle}, key.color);
    }
    for (const auto& line : key.lines) {
      canvas_.text(left + kSample + 6, y, line, "start", css('t', key.color));
      y += kLabelRow;
    }
    y += 4;
  }
}

void Drawing::draw_x_axis(const Layout& layout) {
  for (const auto& tick : x_.ticks) {
    const double x = x_.scale.pixel(tick.value);
    canvas_.line({x, layout.height}, {x, layout.height + 4}, "axis");
    canvas_.text(x, layout.height + 17, tick.text, "middle", "soft");
  }
  canvas_.text(0.5 * (left_ + right_), layout.height + 36, axis_title(plot_.x, x_.unit), "middle", "ink",
               kSubtitleFont);
}

}  // namespace

PlotMap value_map(std::vector<std::string> columns, std::vector<std::string> rows,
                  const std::vector<double>& values, std::optional<double> low, std::optional<double> high) {
  const PlotAxis axis{.low = low, .high = high};
  Extent extent{axis};
  for (const double value : values) extent.add(value);
  const auto range = extent.range(false);
  const auto share = [&](double value) { return (value - range.low) / (range.high - range.low); };
  PlotMap map{std::move(columns), std::move(rows), {}, {}};
  for (const double value : values) map.cells.push_back({.share = share(value)});
  const auto ticks = ticks_of({range.low, range.high, 0, 1}, axis, {}, 6);
  for (auto tick = ticks.rbegin(); tick != ticks.rend(); ++tick)
    map.keys.push_back({{.share = share(tick->value)}, tick->text});
  return map;
}

PlotSeries plot_trace(std::string label, double start, double step, std::vector<double> values) {
  PlotSeries series;
  series.label = std::move(label);
  series.x.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) series.x.push_back(start + step * static_cast<double>(i));
  series.y = std::move(values);
  return series;
}

std::string to_svg(const std::vector<Plot>& page, int columns) {
  Canvas canvas;
  double x = 0, y = 0, row_height = 0, width = 0;
  for (std::size_t i = 0; i < page.size(); ++i) {
    if (i % static_cast<std::size_t>(columns) == 0) x = 0, y += row_height, row_height = 0;
    Drawing drawing{page[i], canvas, fmt::format("p{}s", i)};
    canvas.out("<g transform=\"translate({:.0f} {:.0f})\">\n", x, y);
    drawing.draw();
    canvas.out("</g>\n");
    x += page[i].width;
    width = std::max(width, x);
    row_height = std::max(row_height, drawing.height());
  }
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\" role=\"img\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" "
      "font-size=\"{2}\">\n"
      "<title>{3}</title>\n<style>{4}@media (prefers-color-scheme: dark){{\n{5}}}</style>\n"
      "<rect width=\"100%\" height=\"100%\" class=\"page\"/>\n{6}</svg>\n",
      width, y + row_height, kFont, page.empty() ? "" : escape(page.front().title), rules(kLight, false),
      rules(kDark, true), canvas.take());
}

Status write_svg(const std::filesystem::path& path, const std::vector<Plot>& page, int columns) {
  std::ofstream file{path, std::ios::binary};
  file << to_svg(page, columns);
  file.close();
  if (file) return {};
  return fail(Errc::BadFile, path.string(), "the plot cannot be written",
              "check that the folder exists and may be written to");
}

}  // namespace tactus
