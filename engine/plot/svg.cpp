#include "engine/plot/svg.h"

#include <algorithm>
#include <utility>

#include "engine/plot/svg_canvas.h"
#include "engine/plot/svg_plan.h"

namespace tactus {
namespace {

using namespace svg;

constexpr double kLongestLeader = 120;  // from the end of a series to its label [px]

PlotColor color_of(const PlotPanel& panel, std::size_t series) {
  const auto chosen = panel.series[series].color;
  return chosen != PlotColor::Auto ? chosen : static_cast<PlotColor>(1 + series % 6);
}

class StackedDrawing {
 public:
  /// `clips`: what the names of its clip paths begin with, one for each figure of a page.
  StackedDrawing(const Figure& figure, std::string clips)
      : figure_(figure), plan_(plan_of(figure)), clips_(std::move(clips)) {}

  double height() const { return plan_.height; }
  std::string draw() {
    draw_header();
    for (std::size_t i = 0; i < plan_.panels.size(); ++i) draw_panel(i);
    if (!plan_.panels.empty()) draw_x_axis();
    return canvas_.take();
  }

 private:
  void draw_header();
  void draw_panel(std::size_t index);
  void draw_spans(const PanelPlan& panel, const std::vector<PlotSpan>& spans);
  void draw_events(const PanelPlan& panel, const std::vector<PlotEvent>& events);
  void draw_grid(const PanelPlan& panel);
  void draw_band(const PanelPlan& panel);
  void draw_data(std::size_t index);
  void draw_series(const PanelPlan& panel, const PlotSeries& series, PlotColor color);
  void draw_end_labels(std::size_t index);
  void draw_x_axis();

  const Figure& figure_;
  Plan plan_;
  std::string clips_;
  Canvas canvas_;
};

void StackedDrawing::draw_header() {
  double y = kPad + 14;
  for (const auto& line : plan_.title) {
    canvas_.text(kPad, y, line, "start", kInk, kTitleFont, true);
    y += kTitleRow;
  }
  for (const auto& line : plan_.subtitle) {
    canvas_.text(kPad, y - 2, line, "start", kSoft, kSubtitleFont);
    y += kSubtitleRow;
  }
}

void StackedDrawing::draw_spans(const PanelPlan& panel, const std::vector<PlotSpan>& spans) {
  for (const auto& span : spans) {
    const double from = std::clamp(panel.x.pixel(std::max(span.from, panel.x.low)), plan_.left, plan_.right);
    const double to = std::clamp(panel.x.pixel(std::min(span.to, panel.x.high)), plan_.left, plan_.right);
    canvas_.out(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" opacity=\"0.14\"/>\n",
        from, panel.top, std::max(0.0, to - from), panel.bottom - panel.top, shade(span.color).line);
  }
}

void StackedDrawing::draw_events(const PanelPlan& panel, const std::vector<PlotEvent>& events) {
  for (const auto& event : events) {
    if (!panel.x.shows(event.x) || event.x < panel.x.low || event.x > panel.x.high) continue;
    const double x = panel.x.pixel(event.x);
    canvas_.line(x, panel.top, x, panel.bottom, shade(event.color).line, 1, " stroke-dasharray=\"3 3\"");
  }
}

void StackedDrawing::draw_grid(const PanelPlan& panel) {
  for (const auto& tick : plan_.x_ticks) {
    const double x = panel.x.pixel(tick.value);
    canvas_.line(x, panel.top, x, panel.bottom, "#ededed", 1);
  }
  for (const auto& tick : panel.ticks) {
    const double y = panel.y.pixel(tick.value);
    const bool zero = tick.value == 0.0 && !panel.y.log;
    canvas_.line(plan_.left, y, plan_.right, y, zero ? "#bdbdbd" : "#ededed", 1);
    canvas_.text(plan_.left - 6, y + 4, tick.text, "end", kSoft);
  }
}

void StackedDrawing::draw_band(const PanelPlan& panel) {
  for (std::size_t i = 0; i < panel.band.labels.size(); ++i) {
    const auto& label = panel.band.labels[i];
    if (label.row < 0) continue;
    canvas_.text(label.x, panel.top - 5 - kLabelRow * label.row, panel.band.texts[i], "middle",
                 shade(panel.band.colors[i]).text);
  }
}

void StackedDrawing::draw_panel(std::size_t index) {
  const auto& panel = figure_.panels[index];
  const auto& plan = plan_.panels[index];
  draw_spans(plan, figure_.spans);
  draw_spans(plan, panel.spans);
  draw_grid(plan);
  draw_events(plan, figure_.events);
  draw_events(plan, panel.events);
  draw_data(index);
  canvas_.line(plan_.left, plan.bottom, plan_.right, plan.bottom, "#8a8a8a", 1);
  canvas_.text(kPad, plan.title_y, axis_title(panel.y, plan.unit), "start", kInk, kSubtitleFont, true);
  draw_band(plan);
  draw_end_labels(index);
}

void StackedDrawing::draw_data(std::size_t index) {
  const auto& panel = figure_.panels[index];
  const auto& plan = plan_.panels[index];
  // A little room for the points that lie on the edge.
  canvas_.out(
      "<clipPath id=\"{}{}\"><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
      "height=\"{:.1f}\"/></clipPath>\n",
      clips_, index, plan_.left - 4, plan.top - 4, plan_.right - plan_.left + 8, plan.bottom - plan.top + 8);
  canvas_.out("<g clip-path=\"url(#{}{})\">\n", clips_, index);
  for (std::size_t i = 0; i < panel.series.size(); ++i)
    draw_series(plan, panel.series[i], color_of(panel, i));
  for (const auto& level : panel.levels) {
    const double y = plan.y.pixel(level.y);
    canvas_.line(plan_.left, y, plan_.right, y, shade(level.color).text, 1.2, " stroke-dasharray=\"7 4\"");
  }
  canvas_.out("</g>\n");
}

void StackedDrawing::draw_series(const PanelPlan& panel, const PlotSeries& series, PlotColor color) {
  const auto* stroke = shade(color).line;
  const double foot = std::clamp(panel.y.log ? panel.bottom : panel.y.pixel(0.0), panel.top, panel.bottom);
  for (const auto& line : polylines(series, panel.x, panel.y)) {
    if (series.mark == PlotMark::Line || series.mark == PlotMark::LineAndPoints)
      canvas_.path(line, stroke, series.dashed);
    if (series.mark == PlotMark::Line) continue;
    for (const auto& point : line) {
      if (series.mark == PlotMark::Stems) canvas_.line(point.x, foot, point.x, point.y, stroke, 1.4);
      canvas_.dot(point, stroke);
    }
  }
}

void StackedDrawing::draw_end_labels(std::size_t index) {
  const auto& panel = figure_.panels[index];
  const auto& layout = plan_.panels[index];
  struct Label {
    double x, y;
    std::string text;
    PlotColor color;
  };
  std::vector<Label> labels;
  const auto add = [&](double x, double y, const std::string& text, PlotColor color) {
    if (!text.empty()) labels.push_back({x, std::clamp(y, layout.top, layout.bottom), text, color});
  };
  for (const auto& level : panel.levels) add(plan_.right, layout.y.pixel(level.y), level.label, level.color);
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const auto& series = panel.series[i];
    for (auto n = std::min(series.x.size(), series.y.size()); n-- > 0;) {
      if (!layout.x.shows(series.x[n]) || !layout.y.shows(series.y[n]) || series.x[n] > layout.x.high)
        continue;
      add(layout.x.pixel(series.x[n]), layout.y.pixel(series.y[n]), series.label, color_of(panel, i));
      break;
    }
  }
  std::vector<double> wanted;
  for (const auto& label : labels) wanted.push_back(label.y);
  const auto placed = spread(wanted, kLabelRow, layout.top + 2, layout.bottom - 2);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto& label = labels[i];
    // What ends far from its label has its colour; a leader would cross all that comes after it.
    if (label.x > plan_.right - kLongestLeader)
      canvas_.line(std::max(plan_.left, label.x + 3), label.y, plan_.right + 10, placed[i],
                   shade(label.color).line, 0.8, " opacity=\"0.6\"");
    canvas_.text(plan_.right + 13, placed[i] + 4, label.text, "start", shade(label.color).text, kFont, true);
  }
}

void StackedDrawing::draw_x_axis() {
  const auto& last = plan_.panels.back();
  for (const auto& tick : plan_.x_ticks) {
    const double x = last.x.pixel(tick.value);
    canvas_.line(x, last.bottom, x, last.bottom + 4, "#8a8a8a", 1);
    canvas_.text(x, last.bottom + 17, tick.text, "middle", kSoft);
  }
  canvas_.text(0.5 * (plan_.left + plan_.right), last.bottom + 36, axis_title(figure_.x, plan_.x_unit),
               "middle", kInk, 12.5);
}

}  // namespace

PlotSeries plot_trace(std::string label, double start, double step, std::vector<double> values) {
  PlotSeries series;
  series.label = std::move(label);
  series.x.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) series.x.push_back(start + step * static_cast<double>(i));
  series.y = std::move(values);
  return series;
}

std::string to_svg_page(const std::vector<Figure>& page) {
  Canvas body;
  double height = 0;
  int width = 0;
  for (std::size_t i = 0; i < page.size(); ++i) {
    StackedDrawing drawing{page[i], i == 0 ? "panel" : fmt::format("panel{}_", i)};
    if (i == 0)
      body.out("{}", drawing.draw());
    else
      body.out("<g transform=\"translate(0 {:.0f})\">\n{}</g>\n", height, drawing.draw());
    height += drawing.height();
    width = std::max(width, page[i].width);
  }
  return document(body.take(), page.empty() ? "" : page.front().title, width, height);
}

std::string to_svg(const Figure& figure) { return to_svg_page({figure}); }

Status write_svg(const std::filesystem::path& path, const Figure& figure) {
  return write_svg_page(path, {figure});
}

Status write_svg_page(const std::filesystem::path& path, const std::vector<Figure>& page) {
  return write_document(path, to_svg_page(page));
}

}  // namespace tactus
