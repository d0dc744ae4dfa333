
#include <fmt/format.h>

#include "apps/study/study.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

Json column_json(const BifurcationColumn& column) {
  return {{"value", column.value},
          {"period", column.period},
          {"landing_speeds_m_per_s", column.speeds},
          {"landing_phases", column.phases}};
}

Json doubling_json(const Doubling& doubling) {
  return {{"from_landings", doubling.bounces},
          {"exact", doubling.exact},
          {"simulated", known(doubling.simulated)},
          {"exact_map_swept", known(doubling.swept)}};
}

/// Neighbouring columns of one period in one line.
std::string columns_text(const std::vector<BifurcationColumn>& columns) {
  Table table{{{"from", "to", "landings per orbit"}}};
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
  return value ? fmt::format("{:.4f} ({:+.2f} %)", *value, 100 * (*value / exact - 1)) : "not found";
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
      series.add(column.value, value);
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
  return {{"scene", study.scene},
          {"control", study.control},
          {"frequency_hz", study.frequency_hz},
          {"restitution", study.restitution},
          {"measured_restitution", study.measured_restitution},
          {"doublings", list_of(study.doublings, doubling_json)},
          {"simulated", list_of(study.simulated, column_json)},
          {"exact", list_of(study.exact, column_json)}};
}

std::string text_of(const Bifurcation& study) {
  auto text = fmt::format("{}: {} swept upwards, {:g} Hz\n", study.scene, study.control, study.frequency_hz);
  text +=
      study.measured_restitution > 0
          ? fmt::format("restitution {:.4f} measured, {:.4f} of the ideal ball\n\n",
                        study.measured_restitution, study.restitution)
          : std::string{"no period-1 orbit (one landing per drive period), so no restitution measured\n\n"};
  return text + columns_text(study.simulated) + doublings_text(study);
}

std::vector<Plot> plots_of(const Bifurcation& study) {
  return {
      {.title = study.scene,
       .subtitle = fmt::format("{} swept upwards; restitution {:.3f}", study.control, study.restitution),
       .x = {.label = study.control},
       .subplots = {subplot(study, {.label = "landing speed", .unit = "m/s"}, &BifurcationColumn::speeds),
                    subplot(study, {.label = "phase of the landing, in drive periods", .low = 0, .high = 1},
                            &BifurcationColumn::phases)},
       .subplot_height = 380}};
}

namespace {

struct BifurcationOptions : StudyOptions {
  BifurcationPlan plan;
  std::string over;
  double restitution = 0;
};

/// "gamma=0.9:1.6:48"
void read_over(const std::string& text, const SceneSpec& scene, BifurcationPlan& plan) {
  if (text.empty()) return;
  const auto [name, range] = parse_assignment(text, "--over", "NAME=FROM:TO:COUNT", "gamma=0.9:1.6:48");
  const auto values = parse_spread(range, "--over");
  if (range.find(":log") != std::string::npos || values.size() < 3)
    exit_with({Errc::BadArgument, "--over", "a bifurcation diagram needs three or more equally spaced values",
               "write NAME=FROM:TO:COUNT, with a COUNT of 3 or more"});
  const auto control = find_control(scene, name);
  const auto& dimension = values.front().dimension;
  if (control && dimension && !(*dimension == control->spec->control.unit.dimension))
    exit_with({Errc::UnitMismatch, "--over", "'" + name + "' has another unit", "give it in its unit"});
  plan.control = name;
  plan.from = values.front().si;
  plan.to = values.back().si;
  plan.values = static_cast<int>(values.size());
}

int run_bifurcation(const BifurcationOptions& options) {
  auto plan = options.plan;
  const auto scene = load_target(options);
  read_over(options.over, scene, plan);
  if (!(plan.from < plan.to))
    exit_with({Errc::OutOfRange, "--over", "the end of the sweep must be above its start",
               "write NAME=FROM:TO:COUNT with FROM less than TO"});
  if (options.restitution > 0) plan.restitution = options.restitution;
  read_run_plan(options, plan);
  SweepMonitor monitor{scene.name, plan};
  const auto study = or_exit(study_bifurcation(scene, standard_nodes(), plan));
  if (const auto exit = monitor.end(study.finished, study.runs)) return *exit;
  publish(options, text_of(study), json_of(study), plots_of(study));
  return study.measured_restitution > 0 ? kDone : kNo;
}

}  // namespace

void add_study_bifurcation(CLI::App& study, int& exit_code) {
  auto [command, options] = add_command(
      study, "bifurcation", "Bifurcation diagram of a ball on a driven table, compared with the ideal ball",
      exit_code, run_bifurcation);
  auto& plan = options.plan;
  plan.from = 0.9;
  plan.to = 1.6;
  add_study_options(command, options, "scene with the roles 'ball' and 'table'; for a folder, its scene.toml")
      ->required();
  command.add_option(
      "--over", options.over,
      "NAME=FROM:TO:COUNT; of a control, such as plant.gamma=1.3:1.75:91; default: 0.9:1.6:48 of "
      "the role table_acceleration");
  add_number(command, "--settle", plan.settling_s,
             "settling time at each value, in seconds, before landings are recorded", 0.0, 1000.0);
  add_number(command, "--read", plan.reading_s,
             "time for which landings are recorded at each value, in seconds", 0.1, 1000.0);
  command
      .add_option("--restitution", options.restitution, "restitution of the ideal ball; default: as measured")
      ->check(CLI::Range(0.01, 0.99));
  command.footer(
      "Examples:\n  tactus study bifurcation instruments/bouncing_ball --svg ball.svg\n  tactus study "
      "bifurcation instruments/bouncing_ball/table_scene.toml --over plant.gamma=1.3:1.75:91 --keep "
      "runs\nExit code 1: "
      "no period-1 orbit was found. 5: interrupted.");
}

}  // namespace tactus::app
