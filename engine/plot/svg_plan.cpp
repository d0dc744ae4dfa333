#include "engine/plot/svg_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/plot/note_ticks.h"
#include "engine/plot/svg_canvas.h"

namespace tactus::svg {
namespace {

constexpr int kBandRows = 3;
constexpr double kSvgPlanInfinity = std::numeric_limits<double>::infinity();

void widen(Range& range, double value, bool log) {
  if (!std::isfinite(value) || (log && value <= 0.0)) return;
  range.low = std::min(range.low, value);
  range.high = std::max(range.high, value);
}

Range x_range(const Figure& figure) {
  Range range{kSvgPlanInfinity, -kSvgPlanInfinity};
  bool points = false;
  for (const auto& panel : figure.panels)
    for (const auto& series : panel.series) {
      points = points || series.mark == PlotMark::Points || series.mark == PlotMark::LineAndPoints;
      for (const double value : series.x) widen(range, value, figure.x.log);
    }
  return range_of(figure.x, range.low, range.high, points);
}

Range y_range(const PlotPanel& panel, const Range& x) {
  Range range{kSvgPlanInfinity, -kSvgPlanInfinity};
  for (const auto& series : panel.series) {
    if (series.mark == PlotMark::Stems) widen(range, 0.0, panel.y.log);
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i)
      if (series.x[i] >= x.low && series.x[i] <= x.high) widen(range, series.y[i], panel.y.log);
  }
  for (const auto& level : panel.levels) widen(range, level.y, panel.y.log);
  return range_of(panel.y, range.low, range.high, true);
}

double largest(const Range& range) { return std::max(std::abs(range.low), std::abs(range.high)); }

double plot_height(const Figure& figure, const PlotPanel& panel) {
  return panel.height * figure.panel_height;
}

int most_ticks(double height) { return static_cast<int>(height / 26); }

std::vector<Tick> ticks_on(const PlotPanel& panel, const Scale& y, const PrefixedUnit& unit, double height) {
  return panel.y.notes ? note_ticks(y, most_ticks(height))
                       : ticks_of(y, panel.y.unit, unit, most_ticks(height));
}

double left_margin(const Figure& figure, const Range& x) {
  double width = 0;
  for (const auto& panel : figure.panels) {
    const auto range = y_range(panel, x);
    const double height = plot_height(figure, panel);
    const Scale scale{range.low, range.high, height, 0, panel.y.log};
    for (const auto& tick : ticks_on(panel, scale, prefixed_unit(panel.y.unit, largest(range)), height))
      width = std::max(width, text_width(tick.text, kFont));
  }
  return kPad + width + 8;
}

double right_margin(const Figure& figure) {
  double width = 0;
  for (const auto& panel : figure.panels) {
    for (const auto& series : panel.series) width = std::max(width, text_width(series.label, kFont));
    for (const auto& level : panel.levels) width = std::max(width, text_width(level.label, kFont));
  }
  return kPad + (width > 0 ? width + 14 : 0);
}

void add_to_band(Band& band, double x, const Scale& scale, const std::string& text, PlotColor color) {
  if (text.empty() || !scale.shows(x) || x < scale.low || x > scale.high) return;
  band.labels.push_back({scale.pixel(x), text_width(text, kFont)});
  band.texts.push_back(text);
  band.colors.push_back(color);
}

void add_to_band(Band& band, const std::vector<PlotEvent>& events, const std::vector<PlotSpan>& spans,
                 const Scale& x) {
  for (const auto& event : events) add_to_band(band, event.x, x, event.label, event.color);
  for (const auto& span : spans) {
    const double from = std::max(span.from, x.low);
    const double to = std::min(span.to, x.high);
    add_to_band(band, x.log ? std::sqrt(from * to) : 0.5 * (from + to), x, span.label, span.color);
  }
}

Band band_of(const Figure& figure, std::size_t index, const Scale& x) {
  Band band;
  // What belongs to the whole figure is named once, on top.
  if (index == 0) add_to_band(band, figure.events, figure.spans, x);
  add_to_band(band, figure.panels[index].events, figure.panels[index].spans, x);
  place_in_rows(band.labels, kBandRows, kPad, figure.width - kPad);
  return band;
}

PanelPlan plan_panel(const Figure& figure, std::size_t index, const Scale& x, double at) {
  const auto& panel = figure.panels[index];
  const double height = plot_height(figure, panel);
  const auto y = y_range(panel, {x.low, x.high});
  PanelPlan plan;
  plan.unit = prefixed_unit(panel.y.unit, largest(y));
  plan.x = x;
  plan.band = band_of(figure, index, x);
  plan.title_y = at + 14;
  plan.top = at + (axis_title(panel.y, plan.unit).empty() ? 6 : 21) + kLabelRow * plan.band.rows();
  plan.bottom = plan.top + height;
  plan.y = {y.low, y.high, plan.bottom, plan.top, panel.y.log};
  plan.ticks = ticks_on(panel, plan.y, plan.unit, height);
  return plan;
}

}  // namespace

int Band::rows() const {
  int most = 0;
  for (const auto& label : labels) most = std::max(most, label.row + 1);
  return most;
}

Plan plan_of(const Figure& figure) {
  Plan plan;
  plan.title = wrap(figure.title, kTitleFont, figure.width - 2 * kPad);
  plan.subtitle = wrap(figure.subtitle, kSubtitleFont, figure.width - 2 * kPad);
  const auto range = x_range(figure);
  plan.left = left_margin(figure, range);
  plan.right = figure.width - right_margin(figure);
  plan.x_unit = prefixed_unit(figure.x.unit, largest(range));
  const Scale x{range.low, range.high, plan.left, plan.right, figure.x.log};
  plan.x_ticks = ticks_of(x, figure.x.unit, plan.x_unit, static_cast<int>((plan.right - plan.left) / 80));
  double at = kPad + kTitleRow * static_cast<double>(plan.title.size()) +
              kSubtitleRow * static_cast<double>(plan.subtitle.size()) + 4;
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    plan.panels.push_back(plan_panel(figure, i, x, at));
    at = plan.panels.back().bottom + 10;
  }
  plan.height = at + 44;
  return plan;
}

}  // namespace tactus::svg
