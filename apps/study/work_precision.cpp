#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/play/play_report.h"
#include "apps/study/study.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

std::vector<WorkPoint> by_load(std::vector<WorkPoint> points) {
  std::ranges::stable_sort(points, [](const WorkPoint& a, const WorkPoint& b) {
    return a.known() != b.known() ? a.known() : a.load() < b.load();
  });
  return points;
}

/// An error with marks: the reference is less than ten times more accurate; on the Pareto front.
std::string error_text(const WorkPoint& point, std::size_t a) {
  return fmt::format("{:.2e}{}{}", point.errors[a], point.trusted(a) ? "" : "?", point.front[a] ? " *" : "");
}

/// `auto` with what it chose.
std::string solver_text(const WorkPoint& point) {
  auto text = point.variant.solver;
  for (const auto& network : point.networks)
    text += (text == point.variant.solver ? ": " : ", ") + describe_solver(network);
  return text;
}

std::string steps_text(const WorkPoint& point) {
  return point.variant.oversample == 0 ? "" : std::to_string(point.variant.oversample);
}

std::string refusal_text(const WorkPoint& point) {
  if (!point.refused) return "unstable";
  return (point.is_published() ? "" : "refused: ") + point.refused->what;
}

/// A row per variant, by computing time.
Table table_of(const WorkPrecision& study) {
  Table table{{{"solver", "steps per frame", "rate", "multiplications", "ns per frame", "of real time"}}};
  for (const auto& used : study.references) table.rows[0].push_back(used.accuracy);
  for (const auto& point : by_load(study.points)) {
    auto& row = table.rows.emplace_back();
    row = {solver_text(point), steps_text(point), fmt::format("{:g} kHz", point.variant.rate.value / 1e3)};
    if (point.known())
      row.insert(row.end(),
                 {fmt::format("{:.0f}", point.multiplications), fmt::format("{:.1f}", point.ns_per_frame),
                  fmt::format("{:.2g} %", 100 * point.load())});
    else
      row.insert(row.end(), {"", "", "", refusal_text(point)});
    for (std::size_t a = 0; a < point.errors.size(); ++a) row.push_back(error_text(point, a));
    row.resize(table.rows[0].size());
  }
  return table;
}

std::string own_error_of(const ReferenceUsed& used) {
  if (used.own_error == 0.0) return "";
  return fmt::format(", whose own error is at most {:.1e}", used.own_error);
}

std::string advice(const WorkPrecision& study) {
  std::string text;
  for (const double error : {1e-2, 1e-4}) {
    const auto* point = study.cheapest(error);
    text += fmt::format(
        "Within {:g} %: {}\n", 100 * error,
        point == nullptr ? "none in real time"
                         : fmt::format("{}, {:.0f} ns per frame, {:.2g} % of real time",
                                       to_string(point->variant), point->ns_per_frame, 100 * point->load()));
  }
  return text;
}

std::string percent(double error) { return fmt::format("{:.2g} %", 100 * error); }

/// What `auto` chose at a rate, and what it would have cost to choose by measured errors.
std::string describe(const AutoCost& cost, double tolerance) {
  const auto& chosen = *cost.chosen;
  std::string text = fmt::format("auto at {:g} kHz chose", chosen.variant.rate.value / 1e3);
  for (const auto& network : chosen.networks)
    text += fmt::format("{} {} ({})", &network == &chosen.networks.front() ? "" : " and",
                        describe_solver(network), describe_bound(network));
  text += fmt::format(": measured error at most {}, {:.0f} multiplications", percent(chosen.largest_error()),
                      chosen.multiplications);
  if (const auto ratio = cost.bounded_operations())
    text += fmt::format("; {:.2f} times those of the cheapest solver whose bound is at most {}", *ratio,
                        percent(tolerance));
  if (cost.cheapest == nullptr)
    return text + fmt::format("; no solver that was tried reaches {}", percent(tolerance));
  text += fmt::format("; {:.2f} times those of the cheapest solver whose measured errors are, {}",
                      cost.operations(), to_string(cost.cheapest->variant));
  if (chosen.ns_per_frame > 0) text += fmt::format(", and {:.2f} times its time", cost.times());
  if (cost.published != nullptr)
    text += fmt::format("; the cheapest published method is {}, {:.0f} multiplications",
                        to_string(cost.published->variant), cost.published->multiplications);
  return text;
}

}  // namespace

std::string describe_choices(const WorkPrecision& study) {
  std::string text;
  for (const auto& cost : study.auto_costs()) text += describe(cost, study.tolerance) + "\n";
  return text;
}

std::string text_of(const WorkPrecision& study) {
  auto text = fmt::format("{}\n\n", study.scene);
  for (const auto& used : study.references)
    text += fmt::format("  {}: {} of {}, against {}{}\n", used.accuracy, used.measure, used.of, used.what,
                        own_error_of(used));
  return text + "\n" + table_of(study).text() +
         "\n*: no cheaper variant has a smaller error; ?: less than ten times the reference's own error. "
         "Errors are relative; multiplications are those of a frame.\n" +
         advice(study) + describe_choices(study);
}

std::string markdown_of(const WorkPrecision& study) {
  auto table = table_of(study);
  for (auto& row : table.rows)
    for (auto& cell : row)
      if (cell.ends_with(" *")) cell.replace(cell.size() - 1, 1, "\\*");
  return table.markdown();
}

Json json_of(const WorkPrecision& study) {
  const auto reference_json = [](const ReferenceUsed& used) -> Json {
    return {{"accuracy", used.accuracy},
            {"measure", used.measure},
            {"of", used.of},
            {"against", used.what},
            {"own_error", used.own_error}};
  };
  const auto run_json = [&](const WorkPoint& point) {
    const bool measured = point.known();
    Json run{{"solver", point.variant.solver},
             {"oversample", point.variant.oversample},
             {"sample_rate_hz", point.variant.rate.value},
             {"verdict", point.refused    ? "refused"
                         : point.unstable ? "unstable"
                                          : "ok"},
             {"multiplications_per_frame", known(measured, point.multiplications)},
             {"ns_per_frame", known(measured, point.ns_per_frame)},
             {"of_real_time", known(measured, measured ? point.load() : 0)},
             {"errors", Json::object()},
             {"nothing_cheaper_is_closer", Json::object()}};
    if (point.is_published()) run["published"] = true;
    if (!point.networks.empty()) {
      run["network_solvers"] = networks_json(point.networks);
      run["error_bound"] = known(point.error_bound());
    }
    if (point.refused) run["why"] = to_string(*point.refused);
    for (std::size_t a = 0; a < point.errors.size(); ++a) {
      const auto& accuracy = study.references[a].accuracy;
      run["errors"][accuracy] = point.errors[a];
      run["reference_own_errors"][accuracy] = point.floors[a];
      run["nothing_cheaper_is_closer"][accuracy] = static_cast<bool>(point.front[a]);
    }
    return run;
  };
  const auto cost_json = [&](const AutoCost& cost) -> Json {
    const bool reached = cost.cheapest != nullptr;
    return {{"sample_rate_hz", cost.chosen->variant.rate.value},
            {"asked_error", study.tolerance},
            {"error_bound", known(cost.chosen->error_bound())},
            {"error", cost.chosen->largest_error()},
            {"cheapest", known(reached, reached ? to_string(cost.cheapest->variant) : "")},
            {"operations_ratio", known(reached, reached ? cost.operations() : 0)},
            {"operations_ratio_of_bounds", known(cost.bounded_operations())},
            {"time_ratio", known(reached, reached ? cost.times() : 0)},
            {"words", describe(cost, study.tolerance)}};
  };
  return {{"scene", study.scene},
          {"references", list_of(study.references, reference_json)},
          {"auto", list_of(study.auto_costs(), cost_json)},
          {"runs", list_of(by_load(study.points), run_json)}};
}

namespace {

struct WorkPrecisionArguments : StudyOptions {
  WorkPrecisionOptions plan;
  std::string folder;
  std::vector<std::string> rates;
};

void write_files(const WorkPrecision& study, const std::filesystem::path& folder) {
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  or_exit(write_svg(folder / "work_precision.svg", plots_of(study)));
  or_exit(write_file(folder / "work_precision.md", markdown_of(study)));
  or_exit(write_json(folder / "work_precision.json", json_of(study)));
}

void check_solvers(const std::vector<std::string>& solvers) {
  const auto known = studied_solvers();
  for (const auto& solver : solvers)
    if (std::ranges::find(known, solver) == known.end())
      exit_with({Errc::UnknownName, "--solvers", "there is no solver '" + solver + "'",
                 fmt::format("the solvers are {}", fmt::join(known, ", "))});
}

int run_work_precision(const WorkPrecisionArguments& options) {
  auto plan = options.plan;
  check_solvers(plan.solvers);
  for (const auto& text : options.rates) plan.rates.push_back(parse_rate(text, "rates"));
  read_run_plan(options, plan);
  const auto scene = load_target(options);
  SweepMonitor monitor{scene.name, plan};
  const auto study = or_exit(study_work_precision(scene, standard_nodes(), plan));
  if (const auto exit = monitor.end(study.finished, study.runs)) return *exit;
  publish(options, text_of(study), json_of(study), plots_of(study));
  if (!options.folder.empty()) write_files(study, options.folder);
  return study.cheapest(1.0) == nullptr ? kNo : kDone;
}

}  // namespace

void add_study_work_precision(CLI::App& study, int& exit_code) {
  auto [command, options] = add_command(
      study, "work-precision",
      "Numerical error against computing time for every solver, sample rate and oversampling, beside "
      "published methods",
      exit_code, run_work_precision);
  add_study_options(command, options, "scene with a network; for a folder, its scene.toml")->required();
  command
      .add_option("--solvers", options.plan.solvers,
                  "solvers, such as explicit,passive; default: all, auto, and the published methods verlet, "
                  "newmark, sav and gauss")
      ->delimiter(',');
  command
      .add_option("--rates", options.rates,
                  "sample rates; such as 24kHz,96kHz; default: half, one and two times the scene's")
      ->delimiter(',');
  command.add_option("--oversample", options.plan.oversamples, "steps per frame; default: 1,2,4,8,16")
      ->delimiter(',')
      ->check(CLI::Range(1, 64));
  add_number(command, "--repeat", options.plan.repeats, "number of timing runs; their median is reported", 1,
             1000);
  command
      .add_option("--folder", options.folder,
                  "folder for the files: the plot (SVG), the table (Markdown) and the report (JSON)")
      ->check(writable_folder());
  command.footer(
      "Examples:\n  tactus study work-precision instruments/numerics/stick_impact\n  tactus study "
      "work-precision instruments/numerics/woofer --solvers explicit,passive --rates 48kHz --folder "
      "out/woofer\nThe scene's [accuracy] section lists the compared measures (docs/graph_files.md); without "
      "it the paths of the positions that its networks give are compared. Published methods are written for "
      "this study, not for speed.\nExit "
      "code 1: no variant is both stable and fast enough for real time. 5: interrupted.\nWorkers and --part "
      "share the runs for the errors; times are measured one after another, by a run without --part.");
}

}  // namespace tactus::app
