#include "engine/plot/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

#include "engine/plot/layout.h"

namespace tactus {
namespace {

using namespace plot;

constexpr double kTitleFont = 17, kSubtitleFont = 12.5;                           // [px]
constexpr double kTitleRow = 22, kSubtitleRow = 17, kPad = 16, kWidestCell = 40;  // [px]
constexpr int kEventRows = 3;

// ---- SVG

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

/// Text that is safe between tags.
std::string escape(const std::string& text) {
  static const std::map<char, const char*> kEntities = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string safe;
  for (const char c : text)
    if (const auto entity = kEntities.find(c); entity != kEntities.end())
      safe += entity->second;
    else if (static_cast<unsigned char>(c) >= 0x20)
      safe += c;
  return safe;
}

/// A colour of the ramp, "#00204c" for 0 to "#ffea46" for 1.
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

/// An SVG document that follows the light or dark theme of the reader.
std::string svg_document(double width, double height, const std::string& title, const std::string& elements) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\" role=\"img\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" "
      "font-size=\"{2}\">\n"
      "<title>{3}</title>\n<style>{4}@media (prefers-color-scheme: dark){{\n{5}}}</style>\n"
      "<rect width=\"100%\" height=\"100%\" class=\"page\"/>\n{6}</svg>\n",
      width, height, kFont, escape(title), rules(kLight, false), rules(kDark, true), elements);
}

// ---- a plot

class Drawing {
 public:
  /// `id`: a prefix for the clip paths, unique on the page.
  Drawing(const Plot& plot, Canvas& canvas, std::string id)
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
      if (&layout == &layouts_.front()) label_events(layout, plot.events, {});
      label_events(layout, layout.subplot->events, layout.subplot->bands);
      place_in_rows(layout.event_labels, kEventRows, kPad, plot.width - kPad);
      for (const auto& label : layout.event_labels)
        layout.event_rows = std::max(layout.event_rows, label.row + 1);
      layout.top = height_ + (axis_title(layout.subplot->y, layout.y.unit).empty() ? 6 : 22) +
                   kLabelRow * layout.event_rows;
      height_ = layout.top + std::max(layout.height + 10, layout.legend_height());
    }
    if (!layouts_.empty()) height_ = std::max(height_, layouts_.back().top + layouts_.back().height + 44);
  }

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
  void label_events(Layout& layout, const std::vector<PlotEvent>& events,
                    const std::vector<PlotBand>& bands) {
    const auto add = [&](double x, const std::string& text, PlotColor color) {
      if (text.empty() || !x_.scale.contains(x)) return;
      layout.event_labels.push_back({x_.scale.pixel(x), text_width(text, kFont), -1, text, color});
    };
    for (const auto& event : events) add(event.x, event.label, event.color);
    for (const auto& band : bands) {
      const double from = std::max(band.from, x_.scale.low), to = std::min(band.to, x_.scale.high);
      add(x_.scale.log ? std::sqrt(from * to) : 0.5 * (from + to), band.label, band.color);
    }
  }

  void draw_header() {
    double y = kPad + 14;
    for (const auto& line : title_) {
      canvas_.text(kPad, y, line, "start", "ink", kTitleFont, true);
      y += kTitleRow;
    }
    for (std::size_t i = 0; i < subtitle_.size(); ++i)
      canvas_.text(kPad, y - 2 + kSubtitleRow * static_cast<double>(i), subtitle_[i], "start", "soft",
                   kSubtitleFont);
  }

  void draw_subplot(const Layout& layout, const std::string& clip) {
    const auto& subplot = *layout.subplot;
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
    for (const auto& label : layout.event_labels)
      if (label.row >= 0)
        canvas_.text(label.x, -5 - kLabelRow * label.row, label.text, "middle", css('t', label.color));
    canvas_.text(kPad, -8 - kLabelRow * layout.event_rows, axis_title(subplot.y, layout.y.unit), "start",
                 "ink", kSubtitleFont, true);
    layout.legend ? draw_legend(layout) : draw_end_labels(layout);
    if (&layout == &layouts_.back()) draw_x_axis(layout);
  }

  void draw_bands(const Layout& layout, const std::vector<PlotBand>& bands) {
    const auto pixel = [&](double x) {
      return std::clamp(x_.scale.pixel(std::clamp(x, x_.scale.low, x_.scale.high)), left_, right_);
    };
    for (const auto& band : bands)
      canvas_.rect(pixel(band.from), 0, std::max(0.0, pixel(band.to) - pixel(band.from)), layout.height,
                   fmt::format("class=\"{}\" opacity=\"0.14\"", css('f', band.color)));
  }

  void draw_events(const Layout& layout, const std::vector<PlotEvent>& events) {
    for (const auto& event : events)
      if (x_.scale.contains(event.x)) {
        const double x = x_.scale.pixel(event.x);
        canvas_.line({x, 0}, {x, layout.height}, css('s', event.color), 1, " stroke-dasharray=\"3 3\"");
      }
  }

  void draw_region(const Layout& layout, const PlotRegion& region) {
    const auto edge = [&](const std::vector<double>& values, std::size_t i, double otherwise) {
      return i < values.size() && layout.y.scale.shows(values[i]) ? layout.y.scale.pixel(values[i])
                                                                  : otherwise;
    };
    canvas_.out("<path stroke=\"none\" class=\"{}\" opacity=\"0.13\" d=\"", css('f', region.color));
    const char* step = "M";
    for (std::size_t i = 0; i < region.x.size(); ++i, step = "L")
      canvas_.out("{}{:.1f} {:.1f}", step, x_.scale.pixel(region.x[i]), edge(region.high, i, 0));
    for (std::size_t i = region.x.size(); i-- > 0;)
      canvas_.out("L{:.1f} {:.1f}", x_.scale.pixel(region.x[i]), edge(region.low, i, layout.height));
    canvas_.out("Z\"/>\n");
  }

  void draw_grid(const Layout& layout) {
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

  void draw_series(const Layout& layout, const PlotSeries& series, PlotColor color) {
    const auto &x = x_.scale, &y = layout.y.scale;
    if (series.mark != PlotMark::Points)
      for (const auto& line : polylines(series, x, y)) canvas_.path(line, color, series.dashed);
    if (series.mark == PlotMark::Line) return;
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i)
      if (x.shows(series.x[i]) && y.shows(series.y[i]))
        canvas_.dot({x.pixel(series.x[i]), y.pixel(series.y[i])}, color);
  }

  void draw_cell(double x, double y, double width, double height, const PlotMap::Cell& cell) {
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

  void draw_map(const Layout& layout) {
    const auto& map = *layout.subplot->map;
    const auto columns = std::max<std::size_t>(1, map.columns.size());
    const double width = (right_ - left_) / static_cast<double>(columns);
    const double height = layout.height / static_cast<double>(std::max<std::size_t>(1, map.rows.size()));
    for (std::size_t i = 0; i < map.cells.size(); ++i)
      draw_cell(left_ + static_cast<double>(i % columns) * width,
                layout.height - static_cast<double>(i / columns + 1) * height, width, height, map.cells[i]);
  }

  void draw_pins(const Layout& layout) {
    if (layout.subplot->pins.empty()) return;
    FreeSpace space{{left_, 0, right_, layout.height}};
    for (const auto& series : layout.subplot->series)
      for (const auto& line : polylines(series, x_.scale, layout.y.scale)) space.take(line);
    auto shown = layout.subplot->pins;
    std::erase_if(shown, [&](const PlotPin& pin) {
      return !x_.scale.contains(pin.x) || !layout.y.scale.contains(pin.y);
    });
    for (auto& pin : shown) {
      pin.x = x_.scale.pixel(pin.x), pin.y = layout.y.scale.pixel(pin.y);
      space.take({pin.x - 5, pin.y - 5, pin.x + 5, pin.y + 5});
      canvas_.out("<path d=\"M{:.1f} {:.1f}l5 5l5 -5l-5 -5Z\" class=\"{} dot\"/>\n", pin.x - 5, pin.y,
                  css('f', pin.color));
    }
    for (const auto& pin : shown) {
      if (pin.label.empty()) continue;
      const auto place = space.beside({pin.x, pin.y}, text_width(pin.label, kFont));
      canvas_.text(place.x, place.y, pin.label, place.anchor, css('t', pin.color), kFont, true);
    }
  }

  void draw_end_labels(const Layout& layout) {
    std::vector<double> preferred;
    for (const auto& key : layout.keys)
      preferred.push_back(std::clamp(layout.y.scale.pixel(key.end.y), 0.0, layout.height));
    const auto placed = spread(preferred, kLabelRow, 2, layout.height - 2);
    for (std::size_t i = 0; i < layout.keys.size(); ++i) {
      const auto& key = layout.keys[i];
      const double x = x_.scale.pixel(key.end.x);
      canvas_.line({x + 3, preferred[i]}, {right_ + 10, placed[i]}, css('s', key.color), 0.8,
                   " opacity=\"0.6\"");
      const auto text = fmt::format("{}", fmt::join(key.lines, " "));
      canvas_.text(right_ + 13, placed[i] + 4, text, "start", css('t', key.color), kFont, true);
    }
  }

  void draw_legend(const Layout& layout) {
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

  void draw_x_axis(const Layout& layout) {
    for (const auto& tick : x_.ticks) {
      const double x = x_.scale.pixel(tick.value);
      canvas_.line({x, layout.height}, {x, layout.height + 4}, "axis");
      canvas_.text(x, layout.height + 17, tick.text, "middle", "soft");
    }
    canvas_.text(0.5 * (left_ + right_), layout.height + 36, axis_title(plot_.x, x_.unit), "middle", "ink",
                 kSubtitleFont);
  }

  const Plot& plot_;
  Canvas& canvas_;
  std::string id_;
  std::vector<std::string> title_, subtitle_;
  double left_ = kPad, right_, height_;
  Axis x_;
  std::vector<Layout> layouts_;
};

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
  return svg_document(width, y + row_height, page.empty() ? "" : page.front().title, canvas.take());
}

Status write_svg(const std::filesystem::path& path, const std::vector<Plot>& page, int columns) {
  std::ofstream file{path, std::ios::binary};
  file << to_svg(page, columns);
  file.close();
  if (file) return {};
  return fail(Errc::BadFile, path.generic_string(), "the plot cannot be written",
              "check that the folder exists and is writable");
}

}  // namespace tactus
