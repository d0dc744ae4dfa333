#include <fmt/format.h>

#include <algorithm>

#include "engine/study/work_precision/methods/methods.h"
#include "engine/study/work_precision/work_precision.h"

namespace tactus {
namespace {

// Smaller errors are rounding.
constexpr double kLeastError = 1e-16;

double time_of(const WorkPoint& point) { return 1e-9 * point.ns_per_frame; }
double shown(double error) { return std::max(kLeastError, error); }

/// A published method has the colour of the solver that is most like it.
PlotColor color_of(const std::string& solver) {
  if (solver == "explicit" || solver == "verlet") return PlotColor::Vermillion;
  if (solver == "implicit" || solver == "newmark") return PlotColor::Purple;
  if (solver == "passive" || solver == "sav") return PlotColor::Green;
  return solver == "exact" ? PlotColor::Blue : PlotColor::Orange;
}

std::string label_of(const std::string& solver) {
  const auto* method = find_method(solver);
  return method == nullptr ? solver : method->title;
}

/// The rate that is shown: that of the scene, if it was tried.
Hertz shown_rate(const WorkPrecision& study) {
  const auto is_own = [&](const WorkPoint& point) { return point.variant.rate == study.rate; };
  if (study.points.empty() || std::ranges::any_of(study.points, is_own)) return study.rate;
  return study.points.front().variant.rate;
}

std::vector<const WorkPoint*> shown_points(const WorkPrecision& study) {
  std::vector<const WorkPoint*> points;
  for (const auto& point : study.points)
    if (point.known() && point.ns_per_frame > 0 && point.variant.rate == shown_rate(study))
      points.push_back(&point);
  return points;
}

/// A curve for each solver, over its oversampling.
std::vector<PlotSeries> curves(const WorkPrecision& study, std::size_t a) {
  std::vector<PlotSeries> curves;
  for (const auto* point : shown_points(study)) {
    if (point->is_auto()) continue;
    const auto& solver = point->variant.solver;
    const auto label = label_of(solver);
    auto curve = std::ranges::find(curves, label, &PlotSeries::label);
    if (curve == curves.end())
      curve = curves.insert(curve, {.label = label,
                                    .mark = PlotMark::LineAndPoints,
                                    .color = color_of(solver),
                                    .dashed = point->is_published()});
    curve->add(time_of(*point), shown(point->errors[a]));
  }
  return curves;
}

/// What `auto` chose: a point, with "auto: passive x2" in the legend, under a mark.
void mark_choices(const WorkPrecision& study, std::size_t a, Subplot& plot) {
  for (const auto* point : shown_points(study)) {
    if (!point->is_auto()) continue;
    PlotSeries choice{.label = "auto", .mark = PlotMark::Points, .color = PlotColor::Black};
    for (const auto& network : point->networks)
      choice.label += (choice.label == "auto" ? ": " : ", ") + describe_solver(network);
    choice.add(time_of(*point), shown(point->errors[a]));
    plot.pins.push_back({choice.x[0], choice.y[0]});
    plot.series.push_back(std::move(choice));
  }
}

PlotSeries real_time(const Subplot& plot, double frame_s) {
  double low = 1, high = kLeastError;
  for (const auto& series : plot.series)
    for (const double y : series.y) low = std::min(low, y), high = std::max(high, y);
  return {.label = "limit of real time",
          .x = {frame_s, frame_s},
          .y = {low, high},
          .color = PlotColor::Grey,
          .dashed = true};
}

Plot plot_of(const WorkPrecision& study, std::size_t a) {
  const auto& used = study.references[a];
  const auto rate = shown_rate(study);
  Plot plot;
  plot.title = fmt::format("{} at {:g} kHz: {} ({} of {})", study.scene, rate.value / 1e3, used.accuracy,
                           used.measure, used.of);
  plot.subtitle = "reference: " + used.what + "; dashed: published methods";
  plot.subplot_height = 420;
  plot.x = {.label = "computing time per frame", .unit = "s", .high = 2 / rate.value, .log = true};
  auto& errors = plot.subplots.emplace_back();
  errors.y = {.label = "relative error", .log = true};
  errors.series = curves(study, a);
  mark_choices(study, a, errors);
  errors.series.push_back(real_time(errors, 1 / rate.value));
  return plot;
}

}  // namespace

std::vector<Plot> plots_of(const WorkPrecision& study) {
  std::vector<Plot> plots;
  for (std::size_t a = 0; a < study.references.size(); ++a) plots.push_back(plot_of(study, a));
  return plots;
}

}  // namespace tactus
