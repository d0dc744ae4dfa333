#include <fmt/format.h>

#include <algorithm>

#include "apps/study/study.h"
#include "engine/nodes/table.h"
#include "engine/scene/measures/measure.h"

namespace tactus::app {
namespace {

struct MeasureSweepOptions : SweepOptions {
  std::vector<std::string> measures;
  std::string from, to;
};

/// "440", or with variants "440 (431 to 452)".
std::string cell_text(const SweepTable& table, std::size_t first, std::size_t measure) {
  const auto value = [&](std::size_t point) { return (*table.points[point].result)[measure]; };
  auto text = fmt::format("{:.5g}", value(first));
  if (table.variants.size() == 1) return text;
  double low = value(first), high = low;
  for (std::size_t i = first; i < first + table.variants.size(); ++i)
    low = std::min(low, value(i)), high = std::max(high, value(i));
  return text + fmt::format(" ({:.5g} to {:.5g})", low, high);
}

}  // namespace

std::string text_of(const SweepTable& table) {
  Table text{{{}}};
  for (const auto& swept : table.over) text.rows[0].push_back(swept.name);
  for (const auto& measure : table.measures) {
    const auto unit = unit_of(measure);
    text.rows[0].push_back(measure.name + (unit.empty() ? "" : " [" + unit + "]"));
  }
  for (std::size_t i = 0; i < table.points.size(); i += table.variants.size()) {
    auto& row = text.rows.emplace_back();
    for (std::size_t a = 0; a < table.over.size(); ++a)
      row.push_back(value_text(table.over[a], table.points[i].at[a]));
    for (std::size_t m = 0; m < table.measures.size(); ++m) row.push_back(cell_text(table, i, m));
  }
  const auto note =
      table.variants.size() == 1
          ? std::string{}
          : fmt::format("\nin brackets: lowest and highest value of {} variants\n", table.variants.size());
  return table.scene + "\n\n" + text.text() + note;
}

Json json_of(const SweepTable& table) {
  const auto measure_json = [](const Expectation& measure) -> Json {
    return {
        {"name", measure.name}, {"measure", measure.measure}, {"of", measure.of}, {"unit", unit_of(measure)}};
  };
  Json json{{"scene", table.scene},
            {"over", list_of(table.over, [](const SweptValue& swept) { return swept.name; })},
            {"measures", list_of(table.measures, measure_json)},
            {"runs", Json::array()}};
  for (const auto& point : table.points) {
    Json run{{"at", Json::object()}, {"variant", point.variant}, {"measures", Json::object()}};
    for (std::size_t a = 0; a < table.over.size(); ++a) {
      const auto& swept = table.over[a];
      run["at"][swept.name] = swept.names.empty() ? Json(point.at[a]) : Json(value_text(swept, point.at[a]));
    }
    for (std::size_t m = 0; m < table.measures.size(); ++m)
      run["measures"][table.measures[m].name] = (*point.result)[m];  // null if it is not finite
    json["runs"].push_back(std::move(run));
  }
  return json;
}

namespace {

std::vector<Expectation> read_measures(const MeasureSweepOptions& options, const SceneSpec& scene) {
  std::vector<Expectation> measures;
  for (const auto& text : options.measures) {
    auto& measure = measures.emplace_back(or_exit(find_swept_measure(scene, text), kUsage));
    if (!options.from.empty()) measure.from_s = parse_option(options.from, "s", "measure-from");
    if (!options.to.empty()) measure.to_s = parse_option(options.to, "s", "measure-to");
    if (measure.to_s && measure.from_s.value_or(0) >= *measure.to_s)
      exit_with({Errc::OutOfRange, "--measure-to", "the measurement window must end after it begins",
                 "give --measure-from less than --measure-to"});
  }
  return measures;
}

int run_sweep(const MeasureSweepOptions& options) {
  auto scene = load_target(options);
  auto plan = read_plan(options, scene);
  const auto measures = read_measures(options, scene);
  SweepMonitor monitor{scene.name, plan};
  const auto table = or_exit(sweep_measures(scene, standard_nodes(), plan, measures));
  if (const auto exit = monitor.end(finished(table.points), std::ssize(table.points))) return *exit;
  publish(options, text_of(table), json_of(table), plots_of(table), table.over.size() > 2 ? 2 : 1);
  return kDone;
}

}  // namespace

void add_sweep(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(
      app, "sweep", "Run a scene over ranges of its parameters and measure each run", exit_code, run_sweep);
  add_study_options(command, options, "scene file; for a folder, its scene.toml")->required();
  add_sweep_options(command, options);
  command
      .add_option("--measure", options.measures,
                  "name of an entry in the scene's [expect], or MEASURE:SIGNAL such as rms:instrument.sound")
      ->required()
      ->take_all();
  command.add_option("--measure-from", options.from, "start of the measurement window, such as \"1 s\"");
  command.add_option("--measure-to", options.to, "end of the measurement window, such as \"4 s\"");
  command.footer(
      "Examples:\n  tactus sweep instruments/haptic_drum --over \"delay=0:40:9 ms\" --measure "
      "rate:instrument.hit --svg rate.svg\n  tactus sweep instruments/haptic_drum --over strength=0.2:1:5 "
      "--over \"plant.drum.coil.force_factor=4:8:5 T m\" --measure rate:instrument.hit --svg map.svg\n  "
      "tactus sweep instruments/haptic_drum --draws 200 --within \"10 %\" --measure rate:instrument.hit\n  "
      "parallel tactus sweep SCENE --over strength=0:1:100 --measure peak:plant.cone --keep runs --part {}/8 "
      "::: 1 2 3 4 5 6 7 8\nOne swept parameter is plotted as a line, two as a map, random variations as "
      "points.\nExit code 5: interrupted; with --keep the same command resumes the sweep.");
}

}  // namespace tactus::app
