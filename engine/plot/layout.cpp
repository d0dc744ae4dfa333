#include "engine/plot/layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <ranges>

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

/// The last point that is shown.
std::optional<Point> end_of(const PlotSeries& series, const Scale& x, const Scale& y) {
  for (auto n = std::min(series.x.size(), series.y.size()); n-- > 0;)
    if (x.shows(series.x[n]) && y.shows(series.y[n]) && series.x[n] <= x.high)
      return Point{series.x[n], series.y[n]};
  return std::nullopt;
}

bool continues_utf8(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; }

double em_width(char c) {
  if (std::string_view{" .,:;|!'ijltfI()[]"}.find(c) != std::string_view::npos) return 0.38;
  if (std::string_view{"mwMW%@"}.find(c) != std::string_view::npos) return 0.95;
  if (c >= 'A' && c <= 'Z') return 0.72;
  return 0.62;
}

/// The points of one pixel column that a line through all of them would show.
void append_column(std::vector<Point>& out, const std::vector<Point>& column) {
  if (column.size() <= 4) {
    out.insert(out.end(), column.begin(), column.end());
    return;
  }
  const auto by_y = [](const Point& a, const Point& b) { return a.y < b.y; };
  auto [least, most] = std::ranges::minmax_element(column, by_y);
  if (most < least) std::swap(least, most);  // in the order of time
  out.insert(out.end(), {column.front(), *least, *most, column.back()});
}

}  // namespace

// ---- labels

double text_width(std::string_view text, double font_size) {
  double em = 0.0;
  for (const char c : text)
    if (!continues_utf8(c)) em += em_width(c);
  return em * font_size;
}

std::vector<std::string> wrap(const std::string& text, double font_size, double width) {
  std::vector<std::string> lines;
  std::size_t at = 0;
  while (at < text.size()) {
    auto end = text.find(' ', at);
    if (end == std::string::npos) end = text.size();
    const auto word = text.substr(at, end - at);
    const bool fits = !lines.empty() && text_width(lines.back() + " " + word, font_size) <= width;
    if (fits)
      lines.back() += " " + word;
    else
      lines.push_back(word);
    at = end + 1;
  }
  return lines;
}

std::vector<double> spread(const std::vector<double>& preferred, double gap, double low, double high) {
  std::vector<std::size_t> order(preferred.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](auto a, auto b) { return preferred[a] < preferred[b]; });
  std::vector<double> placed(preferred.size());
  double next = low;
  for (const auto i : order) {
    placed[i] = std::max(preferred[i], next);
    next = placed[i] + gap;
  }
  // Labels pushed beyond the end move back and push their neighbours in turn.
  double last = high;
  for (auto i = order.rbegin(); i != order.rend(); ++i) {
    placed[*i] = std::min(placed[*i], last);
    last = placed[*i] - gap;
  }
  return placed;
}

void place_in_rows(std::vector<RowLabel>& labels, int rows, double low, double high) {
  constexpr double kSpace = 6.0;
  std::vector<double> ends(static_cast<std::size_t>(rows), low - kSpace);
  std::vector<RowLabel*> order;
  for (auto& label : labels) order.push_back(&label);
  std::ranges::stable_sort(order, [](const auto* a, const auto* b) { return a->x < b->x; });
  for (auto* label : order) {
    const double half = label->width / 2;
    label->x = std::max(low + half, std::min(label->x, high - half));
    const auto row =
        std::ranges::find_if(ends, [&](double end) { return end + kSpace <= label->x - half + 1e-9; });
    if (row == ends.end()) continue;
    label->row = static_cast<int>(row - ends.begin());
    *row = label->x + half;
  }
}

std::vector<std::vector<Point>> polylines(const PlotSeries& series, const Scale& x, const Scale& y) {
  std::vector<std::vector<Point>> lines;
  std::vector<Point> line, column;
  const auto end_line = [&] {
    append_column(line, column);
    column.clear();
    if (!line.empty()) lines.push_back(std::move(line));
    line.clear();
  };
  const auto count = std::min(series.x.size(), series.y.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.y[i])) {
      end_line();
      continue;
    }
    const Point point{x.pixel(series.x[i]), y.pixel(series.y[i])};
    if (!column.empty() && std::floor(column.back().x) != std::floor(point.x)) {
      append_column(line, column);
      column.clear();
    }
    column.push_back(point);
  }
  end_line();
  return lines;
}

void FreeSpace::take(const std::vector<Point>& line) {
  constexpr double kStep = 4;  // [px]
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double dx = line[i].x - line[i - 1].x, dy = line[i].y - line[i - 1].y;
    const int steps = 1 + static_cast<int>(std::min(1e4, std::hypot(dx, dy) / kStep));
    for (int n = 0; n <= steps; ++n) {
      const double x = line[i - 1].x + dx * n / steps, y = line[i - 1].y + dy * n / steps;
      take({x - 1, y - 1, x + 1, y + 1});
    }
  }
}

FreeSpace::Place FreeSpace::beside(const Point& point, double width) {
  constexpr double kGap = 7, kHalfLine = 6;  // [px]
  constexpr std::array<Point, 8> kSides = {
      {{1, 0}, {-1, 0}, {0, -1}, {0, 1}, {1, -1}, {1, 1}, {-1, -1}, {-1, 1}}};
  const auto box_at = [&](const Point& side) {
    const double x = point.x + side.x * (kGap + 0.5 * width), y = point.y + side.y * (kGap + kHalfLine);
    return Box{x - 0.5 * width, y - kHalfLine, x + 0.5 * width, y + kHalfLine};
  };
  const auto is_free = [&](const Point& side) {
    const auto box = box_at(side);
    const bool within = box.left >= plot_.left && box.right <= plot_.right && box.top >= plot_.top &&
                        box.bottom <= plot_.bottom;
    return within && std::ranges::none_of(taken_, [&](const Box& other) {
             return box.left < other.right && other.left < box.right && box.top < other.bottom &&
                    other.top < box.bottom;
           });
  };
  const auto found = std::ranges::find_if(kSides, is_free);
  const auto side = found == kSides.end() ? kSides.front() : *found;
  const auto box = box_at(side);
  take(box);
  // The width is an estimate: the anchor is the end that is near the point.
  const char* anchor = side.x > 0 ? "start" : side.x < 0 ? "end" : "middle";
  return {point.x + side.x * kGap, box.bottom - 2, anchor};
}

// ---- a subplot

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
  if (chosen != PlotColor::Auto) return chosen;
  const auto before =
      std::ranges::count(subplot.series | std::views::take(series), PlotColor::Auto, &PlotSeries::color);
  return static_cast<PlotColor>(1 + before % 6);
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
  const Scale x{xs.low, xs.high, 0, 1, plot.x.log};
  const auto add = [&](const std::string& label, PlotColor color) -> Key& {
    keys.push_back({wrap(label, kFont, kLegendText), color});
    return keys.back();
  };
  for (std::size_t i = 0; i < subplot->series.size(); ++i) {
    const auto& series = subplot->series[i];
    const auto end = end_of(series, x, y.scale);
    if (series.label.empty() || !end) continue;
    auto& key = add(series.label, color_of(*subplot, i));
    key.series = &series;
    key.end = *end;
    // A leader from a series that ends early would cross the others; a cloud of points has no end.
    legend = legend || x.pixel(end->x) < kNearEdge || (series.mark == PlotMark::Points && height > 200);
  }
  for (const auto& level : subplot->levels)
    if (!level.label.empty()) add(level.label, level.color).end = {xs.high, level.y};
  for (const auto& region : subplot->regions)
    if (!region.label.empty()) add(region.label, region.color), legend = true;
  if (subplot->map)
    for (const auto& entry : subplot->map->keys)
      add(entry.label, PlotColor::Black).cell = &entry.cell, legend = true;
  legend = legend || kLabelRow * static_cast<double>(keys.size()) > height;
}

}  // namespace tactus::plot
