#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/measures/measure.h"
#include "engine/study/sweep/sweep.h"

namespace tactus {
namespace {

constexpr std::size_t kMostPlots = 12;

/// Values that grow by equal factors, three or more.
bool is_geometric(const SweptValue& swept) {
  const auto& values = swept.values;
  if (values.size() < 3 || !(values.front().si > 0)) return false;
  const double ratio = values[1].si / values[0].si;
  for (std::size_t i = 2; i < values.size(); ++i)
    if (std::abs(values[i].si / values[i - 1].si / ratio - 1) > 1e-6) return false;
  return true;
}

PlotAxis axis_of(const SweptValue& swept) {
  PlotAxis axis{.label = swept.name};
  if (const auto& dimension = swept.values.front().dimension) axis.unit = to_string(*dimension);
  if (swept.what == SweptValue::What::Delay) axis.unit = "s";
  if (swept.what == SweptValue::What::Rate) axis.unit = "Hz";
  if (swept.what == SweptValue::What::Scaled) axis.label += " (factor)";
  for (std::size_t i = 0; i < swept.names.size(); ++i)
    axis.label += fmt::format("{} {} {}", i == 0 ? ":" : ",", i, swept.names[i]);
  axis.log = is_geometric(swept);
  return axis;
}

PlotAxis axis_of(const Expectation& measure) { return {.label = measure.name, .unit = unit_of(measure)}; }

/// Over the first quantity; without one, over the number of the draw.
Subplot curve(const SweepTable& table, std::size_t measure) {
  Subplot subplot{.y = axis_of(table.measures[measure]), .height = table.measures.size() > 1 ? 1.5 : 3.0};
  const bool varied = table.variants.size() > 1;
  PlotSeries line{
      .label = varied ? kAsWritten : "", .mark = PlotMark::LineAndPoints, .color = PlotColor::Blue};
  PlotSeries others{.label = "variants", .mark = PlotMark::Points, .color = PlotColor::Grey};
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const auto& point = table.points[i];
    auto& series = point.as_written() ? line : others;
    series.add(table.over.empty() ? static_cast<double>(i) : point.at[0], (*point.result)[measure]);
  }
  if (varied) subplot.series.push_back(std::move(others));
  subplot.series.push_back(std::move(line));
  return subplot;
}

/// The first two quantities, at one combination of the others; `first` is its first point.
Plot maps(const SweepTable& table, std::size_t first) {
  Plot plot{.title = table.scene, .x = {.label = table.over[0].name}, .width = 640};
  const auto rows = table.over[1].values.size(), columns = table.over[0].values.size();
  const auto row_step = table.points.size() / (columns * rows);
  for (std::size_t m = 0; m < table.measures.size(); ++m) {
    std::vector<double> values;
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t column = 0; column < columns; ++column)
        values.push_back((*table.points[(column * rows + row) * row_step + first].result)[m]);
    const auto axis = axis_of(table.measures[m]);
    plot.subplots.push_back(
        {.y = {.label = fmt::format("{}{}, against {}", axis.label,
                                    axis.unit.empty() ? "" : " [" + axis.unit + "]", table.over[1].name)},
         .map = value_map(value_texts(table.over[0]), value_texts(table.over[1]), values)});
  }
  return plot;
}

}  // namespace

std::vector<Plot> plots_of(const SweepTable& table) {
  if (table.over.size() < 2) {
    Plot plot{.title = table.scene};
    plot.x = table.over.empty() ? PlotAxis{.label = "draw"} : axis_of(table.over[0]);
    for (std::size_t m = 0; m < table.measures.size(); ++m) plot.subplots.push_back(curve(table, m));
    return {plot};
  }
  std::vector<Plot> page;
  const auto step = table.variants.size();
  const auto settings = table.points.size() / (table.over[0].values.size() * table.over[1].values.size());
  for (std::size_t first = 0; first < settings && page.size() < kMostPlots; first += step) {
    page.push_back(maps(table, first));
    const auto& at = table.points[first].at;
    if (at.size() > 2)
      page.back().title +=
          ", " + setting_text({table.over.begin() + 2, table.over.end()}, {at.begin() + 2, at.end()});
  }
  return page;
}

}  // namespace tactus
