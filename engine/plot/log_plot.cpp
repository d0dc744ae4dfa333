#include "engine/plot/log_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/plot/pin_labels.h"
#include "engine/plot/svg_canvas.h"
#include "engine/plot/svg_plan.h"

namespace tactus {
namespace {

using namespace svg;

constexpr double kLogPlotInfinity = std::numeric_limits<double>::infinity();
constexpr double kSample = 26;        // length of a line in the legend [px]
constexpr double kLegendText = 200;   // widest line of text beside it
constexpr double kPlotsApart = 12.0;  // two plots of a page

PlotColor color_of(const LogPlot& plot, std::size_t series) {
  const auto chosen = plot.series[series].color;
  return chosen != PlotColor::Auto ? chosen : static_cast<PlotColor>(1 + series % 6);
}

/// A line of the legend: a curve, or the ground of a region.
struct Key {
  std::vector<std::string> lines;
  PlotColor color;
  const PlotSeries* series = nullptr;
};

std::vector<Key> legend_of(const LogPlot& plot) {
  std::vector<Key> keys;
  for (std::size_t i = 0; i < plot.series.size(); ++i)
    if (const auto& series = plot.series[i]; !series.label.empty())
      keys.push_back({wrap(series.label, kFont, kLegendText), color_of(plot, i), &series});
  for (const auto& region : plot.regions)
    if (!region.label.empty()) keys.push_back({wrap(region.label, kFont, kLegendText), region.color});
  return keys;
}

double legend_width(const std::vector<Key>& keys) {
  double widest = 0;
  for (const auto& key : keys)
    for (const auto& line : key.lines) widest = std::max(widest, text_width(line, kFont));
  return keys.empty() ? 0 : kSample + 6 + widest + 14;
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
  void add(const std::vector<double>& values) {
    for (const double value : values) add(value);
  }
  Range range(bool margin) const { return range_of(axis_, low_, high_, margin); }

 private:
  const PlotAxis& axis_;
  double low_ = kLogPlotInfinity, high_ = -kLogPlotInfinity;
};

Range x_range(const LogPlot& plot) {
  Extent extent{plot.x};
  for (const auto& series : plot.series) extent.add(series.x);
  for (const auto& region : plot.regions) extent.add(region.x);
  for (const auto& pin : plot.pins) extent.add(pin.x);
  return extent.range(!plot.pins.empty());
}

Range y_range(const LogPlot& plot) {
  Extent extent{plot.y};
  for (const auto& series : plot.series) extent.add(series.y);
  for (const auto& pin : plot.pins) extent.add(pin.y);
  return extent.range(true);
}

class Drawing {
 public:
  Drawing(const LogPlot& plot, std::string clip)
      : plot_(plot), clip_(std::move(clip)), keys_(legend_of(plot)) {
    header_ = {wrap(plot.title, kTitleFont, plot.width - 2 * kPad),
               wrap(plot.subtitle, kSubtitleFont, plot.width - 2 * kPad)};
    const auto xs = x_range(plot), ys = y_range(plot);
    top_ = kPad + kTitleRow * static_cast<double>(header_[0].size()) +
           kSubtitleRow * static_cast<double>(header_[1].size()) + 28;
    bottom_ = top_ + plot.height;
    y_ = {ys.low, ys.high, bottom_, top_, plot.y.log};
    y_unit_ = prefixed_unit(plot.y.unit, std::max(std::abs(ys.low), std::abs(ys.high)));
    y_ticks_ = ticks_of(y_, plot.y.unit, y_unit_, plot.height / 30);
    left_ = kPad + tick_width() + 8;
    right_ = plot.width - kPad - legend_width(keys_);
    x_ = {xs.low, xs.high, left_, right_, plot.x.log};
    x_unit_ = prefixed_unit(plot.x.unit, std::max(std::abs(xs.low), std::abs(xs.high)));
    x_ticks_ = ticks_of(x_, plot.x.unit, x_unit_, static_cast<int>((right_ - left_) / 80));
  }

  double height() const { return bottom_ + 44; }
  std::string draw() {
    draw_header();
    open_clip();
    for (const auto& region : plot_.regions) draw_region(region);
    canvas_.out("</g>\n");
    draw_grid();
    canvas_.out("<g clip-path=\"url(#{})\">\n", clip_);
    for (std::size_t i = 0; i < plot_.series.size(); ++i) draw_series(i);
    canvas_.out("</g>\n");
    draw_pins();
    draw_legend();
    return canvas_.take();
  }

 private:
  double tick_width() const {
    double widest = 0;
    for (const auto& tick : y_ticks_) widest = std::max(widest, text_width(tick.text, kFont));
    return widest;
  }
  void draw_header();
  void open_clip();
  void draw_region(const PlotRegion& region);
  void draw_grid();
  void draw_series(std::size_t index);
  void draw_pins();
  void draw_key(const Key& key, double y);
  void draw_legend();

  const LogPlot& plot_;
  std::string clip_;
  std::vector<Key> keys_;
  std::array<std::vector<std::string>, 2> header_;
  double left_, right_, top_, bottom_;
  Scale x_, y_;
  PrefixedUnit x_unit_, y_unit_;
  std::vector<Tick> x_ticks_, y_ticks_;
  Canvas canvas_;
};

void Drawing::draw_header() {
  double y = kPad + 14;
  for (const auto& line : header_[0]) {
    canvas_.text(kPad, y, line, "start", kInk, kTitleFont, true);
    y += kTitleRow;
  }
  for (const auto& line : header_[1]) {
    canvas_.text(kPad, y - 2, line, "start", kSoft, kSubtitleFont);
    y += kSubtitleRow;
  }
  canvas_.text(kPad, top_ - 9, axis_title(plot_.y, y_unit_), "start", kInk, kSubtitleFont, true);
  canvas_.text(0.5 * (left_ + right_), bottom_ + 36, axis_title(plot_.x, x_unit_), "middle", kInk,
               kSubtitleFont, true);
}

void Drawing::open_clip() {
  canvas_.out(
      "<clipPath id=\"{}\"><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/></clipPath>\n",
      clip_, left_, top_, right_ - left_, bottom_ - top_);
  canvas_.out("<g clip-path=\"url(#{})\">\n", clip_);
}

void Drawing::draw_region(const PlotRegion& region) {
  const auto edge = [&](const std::vector<double>& values, std::size_t i, double otherwise) {
    return i < values.size() && y_.shows(values[i]) ? y_.pixel(values[i]) : otherwise;
  };
  canvas_.out("<path stroke=\"none\" fill=\"{}\" opacity=\"0.13\" d=\"", shade(region.color).line);
  const char* step = "M";
  for (std::size_t i = 0; i < region.x.size(); ++i, step = "L")
    canvas_.out("{}{:.1f} {:.1f}", step, x_.pixel(region.x[i]), edge(region.high, i, top_));
  for (std::size_t i = region.x.size(); i-- > 0;)
    canvas_.out("L{:.1f} {:.1f}", x_.pixel(region.x[i]), edge(region.low, i, bottom_));
  canvas_.out("Z\"/>\n");
}

void Drawing::draw_grid() {
  for (const auto& tick : x_ticks_) {
    const double x = x_.pixel(tick.value);
    canvas_.line(x, top_, x, bottom_, "#dedede", 1);
    canvas_.line(x, bottom_, x, bottom_ + 4, "#8a8a8a", 1);
    canvas_.text(x, bottom_ + 17, tick.text, "middle", kSoft);
  }
  for (const auto& tick : y_ticks_) {
    const double y = y_.pixel(tick.value);
    canvas_.line(left_, y, right_, y, "#dedede", 1);
    canvas_.text(left_ - 6, y + 4, tick.text, "end", kSoft);
  }
  canvas_.line(left_, bottom_, right_, bottom_, "#8a8a8a", 1);
  canvas_.line(left_, top_, left_, bottom_, "#8a8a8a", 1);
}

void Drawing::draw_series(std::size_t index) {
  const auto& series = plot_.series[index];
  const auto* stroke = shade(color_of(plot_, index)).line;
  for (const auto& line : polylines(series, x_, y_)) {
    if (series.mark == PlotMark::Line || series.mark == PlotMark::LineAndPoints)
      canvas_.path(line, stroke, series.dashed);
    if (series.mark == PlotMark::Line) continue;
    for (const auto& point : line) canvas_.dot(point, stroke);
  }
}

void Drawing::draw_pins() {
  PinLabels labels{{left_, top_, right_, bottom_}};
  for (const auto& series : plot_.series)
    for (const auto& line : polylines(series, x_, y_)) labels.take(line);
  const auto shown = [&](const PlotPin& pin) {
    return x_.shows(pin.x) && y_.shows(pin.y) && pin.x >= x_.low && pin.x <= x_.high && pin.y >= y_.low &&
           pin.y <= y_.high;
  };
  for (const auto& pin : plot_.pins) {
    if (!shown(pin)) continue;
    const double x = x_.pixel(pin.x), y = y_.pixel(pin.y);
    labels.take(Box{x - 5, y - 5, x + 5, y + 5});
    canvas_.out(
        "<path d=\"M{0:.1f} {2:.1f}L{4:.1f} {1:.1f}L{0:.1f} {3:.1f}L{5:.1f} {1:.1f}Z\" fill=\"{6}\" "
        "stroke=\"#ffffff\" stroke-width=\"1\"/>\n",
        x, y, y - 5, y + 5, x + 5, x - 5, shade(pin.color).line);
  }
  for (const auto& pin : plot_.pins) {
    if (!shown(pin) || pin.label.empty()) continue;
    const auto place = labels.beside({x_.pixel(pin.x), y_.pixel(pin.y)}, text_width(pin.label, kFont));
    canvas_.text(place.x, place.y, pin.label, place.anchor, shade(pin.color).text, kFont, true);
  }
}

void Drawing::draw_key(const Key& key, double y) {
  const double left = right_ + 14, middle = y - 4;
  const auto* color = shade(key.color).line;
  if (key.series == nullptr) {
    canvas_.out("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"10\" fill=\"{}\" opacity=\"0.25\"/>\n",
                left, middle - 5, kSample, color);
    return;
  }
  if (key.series->mark != PlotMark::Points)
    canvas_.path({{left, middle}, {left + kSample, middle}}, color, key.series->dashed);
  if (key.series->mark != PlotMark::Line) canvas_.dot({left + 0.5 * kSample, middle}, color);
}

void Drawing::draw_legend() {
  double y = top_ + 10;
  for (const auto& key : keys_) {
    draw_key(key, y);
    for (const auto& line : key.lines) {
      canvas_.text(right_ + 14 + kSample + 6, y, line, "start", shade(key.color).text);
      y += kLabelRow;
    }
    y += 5;
  }
}

}  // namespace

std::string log_plots_svg(const std::vector<LogPlot>& page) {
  Canvas body;
  double height = 0;
  int width = 0;
  for (std::size_t i = 0; i < page.size(); ++i) {
    if (i > 0) height += kPlotsApart;
    Drawing drawing{page[i], fmt::format("plot{}", i)};
    body.out("<g transform=\"translate(0 {:.0f})\">\n{}</g>\n", height, drawing.draw());
    height += drawing.height();
    width = std::max(width, page[i].width);
  }
  return document(body.take(), page.empty() ? "" : page.front().title, width, height);
}

Status write_log_plots(const std::filesystem::path& path, const std::vector<LogPlot>& page) {
  return write_document(path, log_plots_svg(page));
}

}  // namespace tactus
