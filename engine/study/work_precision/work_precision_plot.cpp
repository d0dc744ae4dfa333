#include <fmt/format.h>

#include <algorithm>

#include "engine/study/work_precision/work_precision.h"

namespace tactus {
namespace {

// Smaller errors are rounding.
constexpr double kLeastError = 1e-16;
// Computing time is shown for this time of the scene, so that rates can be compared.
constexpr double kShownSpan_s = 1.0 / 48000;

double time_of(const WorkPoint& point) { return point.load() * kShownSpan_s; }
double shown(double error) { return std::max(kLeastError, error); }

PlotColor color_of(const std::string& solver) {
  if (solver == "explicit") return PlotColor::Vermillion;
  if (solver == "exact") return PlotColor::Blue;
  if (solver == "implicit") return PlotColor::Purple;
  return solver == "passive" ? PlotColor::Green : PlotColor::Orange;
}

/// One solver at one rate over its oversampling.
PlotSeries curve(const WorkPrecision& study, const SolverVariant& of, std::size_t a) {
  PlotSeries series;
  series.label = fmt::format("{}, {:g} kHz", of.solver, of.rate.value / 1e3);
  series.color = color_of(of.solver);
  series.mark = PlotMark::LineAndPoints;
  for (const auto& point : study.points) {
    if (point.variant.solver != of.solver || point.variant.rate.value != of.rate.value || !point.known())
      continue;
    series.x.push_back(time_of(point));
    series.y.push_back(shown(point.errors[a]));
  }
  return series;
}

/// The Pareto front, as steps: no variant is both cheaper and more accurate.
PlotSeries front(const WorkPrecision& study, std::size_t a) {
  std::vector<std::pair<double, double>> corners;
  for (const auto& point : study.points)
    if (point.known() && point.front[a]) corners.emplace_back(time_of(point), shown(point.errors[a]));
  std::ranges::sort(corners);
  PlotSeries series{.label = "Pareto front", .color = PlotColor::Black};
  for (const auto& [x, y] : corners) {
    if (!series.y.empty()) series.x.push_back(x), series.y.push_back(series.y.back());
    series.x.push_back(x);
    series.y.push_back(y);
  }
  return series;
}

PlotSeries real_time(const Subplot& plot) {
  double low = 1, high = kLeastError;
  for (const auto& series : plot.series)
    for (const double y : series.y) low = std::min(low, y), high = std::max(high, y);
  return {.label = "limit of real time",
          .x = {kShownSpan_s, kShownSpan_s},
          .y = {low, high},
          .color = PlotColor::Grey,
          .dashed = true};
}

Plot plot_of(const WorkPrecision& study, std::size_t a) {
  const auto& used = study.references[a];
  Plot plot;
  plot.title = fmt::format("{}: {} ({} of {})", study.scene, used.accuracy, used.measure, used.of);
  plot.subtitle = "reference: " + used.what;
  plot.subplot_height = 420;
  plot.x = {.label = "computing time for 1/48000 s of the scene",
            .unit = "s",
            .high = 2 * kShownSpan_s,
            .log = true};
  auto& errors = plot.subplots.emplace_back();
  errors.y = {.label = "relative error", .log = true};
  for (std::size_t i = 0; i < study.points.size(); ++i) {
    const auto& variant = study.points[i].variant;
    const auto same = [&](const WorkPoint& other) {
      return other.variant.solver == variant.solver && other.variant.rate.value == variant.rate.value;
    };
    const auto begin = study.points.begin();
    if (std::find_if(begin, study.points.end(), same) != begin + static_cast<std::ptrdiff_t>(i)) continue;
    auto series = curve(study, variant, a);
    if (!series.x.empty()) errors.series.push_back(std::move(series));
  }
  auto edge = front(study, a);
  if (!edge.x.empty()) errors.series.push_back(std::move(edge));
  errors.series.push_back(real_time(errors));
  return plot;
}

}  // namespace

std::vector<Plot> plots_of(const WorkPrecision& study) {
  std::vector<Plot> plots;
  for (std::size_t a = 0; a < study.references.size(); ++a) plots.push_back(plot_of(study, a));
  return plots;
}

}  // namespace tactus
