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

/// A curve for each solver and rate, over its oversampling.
std::vector<PlotSeries> curves(const WorkPrecision& study, std::size_t a) {
  std::vector<PlotSeries> curves;
  for (const auto& point : study.points) {
    if (!point.known()) continue;
    const auto& variant = point.variant;
    const auto label = fmt::format("{}, {:g} kHz", variant.solver, variant.rate.value / 1e3);
    auto curve = std::ranges::find(curves, label, &PlotSeries::label);
    if (curve == curves.end())
      curve = curves.insert(
          curve, {.label = label, .mark = PlotMark::LineAndPoints, .color = color_of(variant.solver)});
    curve->add(time_of(point), shown(point.errors[a]));
  }
  return curves;
}

/// The Pareto front, as steps: no variant is both cheaper and more accurate.
PlotSeries front(const WorkPrecision& study, std::size_t a) {
  std::vector<std::pair<double, double>> corners;
  for (const auto& point : study.points)
    if (point.known() && point.front[a]) corners.emplace_back(time_of(point), shown(point.errors[a]));
  std::ranges::sort(corners);
  PlotSeries series{.label = "Pareto front", .color = PlotColor::Black};
  for (const auto& [x, y] : corners) {
    if (!series.y.empty()) series.add(x, series.y.back());
    series.add(x, y);
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
  errors.series = curves(study, a);
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
