#include <fmt/format.h>

#include "apps/study/reports.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

Json part_json(const std::vector<BifurcationColumn>& columns) {
  auto list = Json::array();
  for (const auto& column : columns)
    list.push_back({{"value", column.value},
                    {"period", column.period},
                    {"landing_speeds_m_per_s", column.speeds},
                    {"landing_phases", column.phases}});
  return list;
}

Json number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// Neighbouring columns of one period in one line.
std::string columns_text(const std::vector<BifurcationColumn>& columns) {
  Table table{{{"from", "to", "landings until it repeats"}}};
  for (std::size_t i = 0; i < columns.size();) {
    std::size_t end = i;
    while (end < columns.size() && columns[end].period == columns[i].period) ++end;
    table.rows.push_back({fmt::format("{:.5g}", columns[i].value),
                          fmt::format("{:.5g}", columns[end - 1].value),
                          columns[i].period == 0 ? "none" : std::to_string(columns[i].period)});
    i = end;
  }
  return table.text();
}

std::string doubling_text(const std::optional<double>& value, double exact) {
  return value ? fmt::format("{:.4f} ({:+.2f} %)", *value, 100 * (*value / exact - 1)) : "not seen";
}

std::string doublings_text(const Bifurcation& study) {
  if (study.doublings.empty()) return {};
  Table table{{{"landings", "exact", "simulated", "exact map, swept"}}};
  for (const auto& doubling : study.doublings)
    table.rows.push_back({fmt::format("{} to {}", doubling.bounces, 2 * doubling.bounces),
                          fmt::format("{:.6f}", doubling.exact),
                          doubling_text(doubling.simulated, doubling.exact),
                          doubling_text(doubling.swept, doubling.exact)});
  return "\n" + table.text();
}

PlotSeries points(const std::vector<BifurcationColumn>& columns, const std::string& label, PlotColor color,
                  std::vector<double> BifurcationColumn::*of) {
  PlotSeries series{.label = label, .mark = PlotMark::Points, .color = color};
  for (const auto& column : columns)
    for (const double value : column.*of) {
      series.x.push_back(column.value);
      series.y.push_back(value);
    }
  return series;
}

Subplot subplot(const Bifurcation& study, PlotAxis y, std::vector<double> BifurcationColumn::*of) {
  Subplot made{.y = std::move(y)};
  if (!study.exact.empty()) made.series.push_back(points(study.exact, "ideal ball", PlotColor::Grey, of));
  made.series.push_back(points(study.simulated, "simulated", PlotColor::Blue, of));
  return made;
}

}  // namespace

Json json_of(const Bifurcation& study) {
  Json json{{"scene", study.scene},
            {"control", study.control},
            {"frequency_hz", study.frequency_hz},
            {"restitution", study.restitution},
            {"measured_restitution", study.measured_restitution},
            {"doublings", Json::array()}};
  for (const auto& doubling : study.doublings)
    json["doublings"].push_back({{"from_landings", doubling.bounces},
                                 {"exact", doubling.exact},
                                 {"simulated", number(doubling.simulated)},
                                 {"exact_map_swept", number(doubling.swept)}});
  json["simulated"] = part_json(study.simulated);
  json["exact"] = part_json(study.exact);
  return json;
}

std::string text_of(const Bifurcation& study) {
  auto text = fmt::format("{}: {} swept up, {:g} Hz\n", study.scene, study.control, study.frequency_hz);
  text += study.measured_restitution > 0
              ? fmt::format("restitution {:.4f} as measured, {:.4f} of the ideal ball\n\n",
                            study.measured_restitution, study.restitution)
              : std::string{"no landings that repeat one by one: no restitution measured\n\n"};
  return text + columns_text(study.simulated) + doublings_text(study);
}

std::vector<Plot> plots_of(const Bifurcation& study) {
  return {
      {.title = study.scene,
       .subtitle = fmt::format("{} swept up; restitution {:.3f}", study.control, study.restitution),
       .x = {.label = study.control},
       .subplots = {subplot(study, {.label = "landing speed", .unit = "m/s"}, &BifurcationColumn::speeds),
                    subplot(study, {.label = "phase of the landing, in drive periods", .low = 0, .high = 1},
                            &BifurcationColumn::phases)},
       .subplot_height = 380}};
}

}  // namespace tactus::app
