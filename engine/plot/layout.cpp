#include "engine/plot/layout.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/plot/svg.h"

namespace tactus::plot {
namespace {

constexpr double kLegendText = 200, kHighestCell = 24, kHighestMap = 480;  // [px]

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

/// The last point that is shown, in shares of the axes.
std::optional<Point> end_of(const PlotSeries& series, const Range& xs, const Range& ys, const Plot& plot,
                            const Subplot& subplot) {
  const Scale x{xs.low, xs.high, 0, 1, plot.x.log}, y{ys.low, ys.high, 0, 1, subplot.y.log};
  for (auto n = std::min(series.x.size(), series.y.size()); n-- > 0;)
    if (x.shows(series.x[n]) && y.shows(series.y[n]) && series.x[n] <= x.high)
      return Point{x.pixel(series.x[n]), std::clamp(y.pixel(series.y[n]), 0.0, 1.0)};
  return std::nullopt;
}

}  // namespace

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

Axis make_axis(const PlotAxis& axis, const Range& range, double pixel_low, double pixel_high,
               double per_tick) {
  Axis made;
  made.scale = {range.low, range.high, pixel_low, pixel_high, axis.log};
  made.unit = prefixed_unit(axis.unit, std::max(std::abs(range.low), std::abs(range.high)));
  made.ticks =
      ticks_of(made.scale, axis, made.unit, static_cast<int>(std::abs(pixel_high - pixel_low) / per_tick));
  return made;
}

Axis make_axis(const std::vector<std::string>& names, double pixel_low, double pixel_high, double per_tick) {
  const auto count = static_cast<double>(std::max<std::size_t>(1, names.size()));
  Axis made{{0, count, pixel_low, pixel_high}, {}, {}};
  const auto every = static_cast<std::size_t>(
      std::max(1.0, std::ceil(per_tick * count / std::max(1.0, std::abs(pixel_high - pixel_low)))));
  for (std::size_t i = 0; i < names.size(); i += every)
    made.ticks.push_back({static_cast<double>(i) + 0.5, names[i]});
  return made;
}

double widest(const std::vector<std::string>& texts) {
  double most = 0;
  for (const auto& text : texts) most = std::max(most, text_width(text, kFont));
  return most;
}

PlotColor color_of(const Subplot& subplot, std::size_t series) {
  const auto chosen = subplot.series[series].color;
  return chosen != PlotColor::Auto ? chosen : static_cast<PlotColor>(1 + series % 6);
}

Layout::Layout(const Plot& plot, const Subplot& of, const Range& xs)
    : subplot(&of), y_values(y_range(of, xs)) {
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

double Layout::key_width() const {
  double most = 0;
  for (const auto& key : keys) most = std::max(most, widest(key.lines));
  return keys.empty() ? 0 : most + 14 + (legend ? kSample + 6 : 0);
}

double Layout::legend_height() const {
  double rows = 0;
  for (const auto& key : keys) rows += kLabelRow * static_cast<double>(key.lines.size()) + 4;
  return legend ? rows : 0;
}

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

}  // namespace tactus::plot
