#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>

#include "apps/cli/target.h"
#include "apps/study/study.h"
#include "engine/core/dimension.h"
#include "engine/graph/file/quantity.h"

namespace tactus::app {
namespace {

constexpr double kMostValues = 10000;

/// Numbers with the one unit that follows some of them: "0.2:3.2:7:log", "55:880:9:log Hz".
struct Written {
  std::vector<double> numbers;
  std::string unit;
  bool log = false;
};

[[noreturn]] void exit_unreadable(const std::string& text, const std::string& option,
                                  const std::string& remedy) {
  exit_with({Errc::Syntax, option, "'" + text + "' is not a range", remedy});
}

Written read_numbers(const std::string& text, const std::string& option, const std::string& remedy) {
  Written written;
  for (const auto& part : CLI::detail::split(text, ':')) {
    const char* rest = part.c_str();
    if (part == "log" || part.starts_with("log ")) {
      written.log = true;
      rest += 3;
    } else {
      char* end = nullptr;
      written.numbers.push_back(std::strtod(part.c_str(), &end));
      if (end == rest || !std::isfinite(written.numbers.back())) exit_unreadable(text, option, remedy);
      rest = end;
    }
    while (*rest == ' ') ++rest;
    const std::string unit{rest};
    if (unit.empty()) continue;
    if (!written.unit.empty() && written.unit != unit)
      exit_with({Errc::UnitMismatch, option,
                 "'" + text + "' mixes the units " + written.unit + " and " + unit,
                 "use one unit for all values"});
    written.unit = unit;
  }
  return written;
}

/// `count` numbers, number_of(0) and so on, in the unit that was written.
std::vector<ControlValue> spread(const Written& written, double count, const std::string& option,
                                 const std::function<double(int)>& number_of) {
  if (!(count >= 1 && count <= kMostValues))
    exit_with({Errc::OutOfRange, option, fmt::format("a sweep cannot have {:g} values", count),
               fmt::format("choose 1 to {:g}", kMostValues)});
  std::vector<ControlValue> values;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    // A number as it would be written: 0.3, not 0.1 + 0.2.
    const auto number = fmt::format("{:.12g}", number_of(i));
    const auto value = parse_quantity(number + " " + written.unit);
    if (!value) exit_with({Errc::Syntax, option, "'" + written.unit + "' is not a unit", ""});
    values.push_back(QuantityValue{value->si, value->unit, written.unit.empty()});
  }
  return values;
}

/// From the first number by equal steps.
std::vector<ControlValue> evenly(const Written& written, double step, double count,
                                 const std::string& option) {
  return spread(written, count, option, [&](int i) { return written.numbers[0] + i * step; });
}

}  // namespace

std::vector<ControlValue> parse_steps(const std::string& text, const std::string& option) {
  const auto* remedy = "write FROM:TO:STEP, as in \"0:40:1 ms\"";
  const auto written = read_numbers(text, option, remedy);
  const auto& numbers = written.numbers;
  if (numbers.size() == 1 && !written.log) return evenly(written, 0, 1, option);
  if (numbers.size() != 3 || !(numbers[2] > 0) || numbers[1] < numbers[0] || written.log)
    exit_unreadable(text, option, remedy);
  return evenly(written, numbers[2], std::floor((numbers[1] - numbers[0]) / numbers[2] + 1e-9) + 1, option);
}

std::vector<ControlValue> parse_spread(const std::string& text, const std::string& option) {
  const auto* remedy = "write FROM:TO:COUNT, as in \"0.2:1:5\", or FROM:TO:COUNT:log";
  const auto written = read_numbers(text, option, remedy);
  const auto& numbers = written.numbers;
  if (numbers.size() == 1 && !written.log) return evenly(written, 0, 1, option);
  if (numbers.size() != 3 || numbers[2] != std::floor(numbers[2])) exit_unreadable(text, option, remedy);
  const double intervals = std::max(1.0, numbers[2] - 1);
  if (!written.log) return evenly(written, (numbers[1] - numbers[0]) / intervals, numbers[2], option);
  if (!(numbers[0] * numbers[1] > 0))
    exit_with({Errc::OutOfRange, option, "'" + text + "' cannot be spaced logarithmically",
               "choose both ends above 0, or omit ':log'"});
  const double ratio = numbers[1] / numbers[0];
  return spread(written, numbers[2], option,
                [&](int i) { return numbers[0] * std::pow(ratio, i / intervals); });
}

namespace {

SweptValue read_swept(const std::string& text, const SceneSpec& scene) {
  const auto [name, range] = parse_assignment(text, "--over", "NAME=FROM:TO:COUNT", "strength=0.2:1:5");
  if (name == "solver") return or_exit(swept_solvers(CLI::detail::split(range, ',')), kUsage);
  return or_exit(find_swept(scene, name, parse_spread(range, "--over")), kUsage);
}

/// "2/4": the second of four shares.
void read_part(const std::string& text, RunPlan& plan) {
  if (text.empty()) return;
  int part = 0, parts = 0, read = 0;
  const bool whole = std::sscanf(text.c_str(), "%d/%d%n", &part, &parts, &read) == 2 &&
                     read == static_cast<int>(text.size());
  if (!whole || part < 1 || part > parts || parts > 10000)
    exit_with({Errc::Syntax, "--part", "'" + text + "' is not of the form I/N, part I of N",
               "write for instance 2/4"});
  if (plan.cache.empty())
    exit_with({Errc::Missing, "--part", "the parts of a sweep need a folder for their results",
               "add --keep FOLDER"});
  plan.part = part - 1;
  plan.parts = parts;
}

/// "6 dB": both ways. A bare number might be meant as decibels or as a factor.
void read_gain(const std::string& text, SweepPlan& plan) {
  if (text.empty()) return;
  const double gain = parse_option(text, "", "gain", kAboveZero, 100);
  if (read_quantity(Value{text, {}})->bare)
    exit_with({Errc::UnitMismatch, "--gain", "'" + text + "' must be in decibels or a factor",
               fmt::format("write \"{0} dB\", or \"{1:g} %\" for a gain factor of {0}", text, 100 * gain)});
  plan.gains = {1 / gain, gain};
}

/// A swept quantity has no other value.
void check_swept_once(const SweepPlan& plan) {
  for (auto swept = plan.over.begin(); swept != plan.over.end(); ++swept) {
    const auto same = [&](const SweptValue& other) { return other.name == swept->name; };
    if (std::any_of(plan.over.begin(), swept, same))
      exit_with({Errc::BadArgument, "--over", "'" + swept->name + "' is swept twice", "sweep it once"});
    if (plan.set.contains(swept->name))
      exit_with({Errc::BadArgument, "--set",
                 "'" + swept->name + "' is swept by --over and cannot be set by --set, too",
                 "omit one of them"});
  }
}

std::string remaining_text(double seconds) {
  if (seconds < 60) return fmt::format("{:.0f} s left", seconds);
  return seconds < 3600 ? fmt::format("{:.0f} min left", seconds / 60)
                        : fmt::format("{:.1f} h left", seconds / 3600);
}

}  // namespace

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) text += fmt::format("  {:>{}}", row[c], widths[c]);
    text += "\n";
  }
  return text;
}

std::string Table::markdown() const {
  std::string text;
  for (const auto& row : rows) {
    text += fmt::format("| {} |\n", fmt::join(row, " | "));
    if (&row != &rows.front()) continue;
    for (std::size_t c = 0; c < row.size(); ++c) text += "|---";
    text += "|\n";
  }
  return text;
}

CLI::Option* add_study_options(CLI::App& command, StudyOptions& options, const std::string& scene) {
  command.add_option("--svg", options.picture, "write the plots to this SVG file")->check(writable_file());
  command.add_flag("--json", options.json, "print the report as JSON");
  command
      .add_option("--keep", options.cache, "save finished runs in this folder, and skip those already there")
      ->check(writable_folder());
  command.add_option(
      "--part", options.part,
      "I/N: run only part I of N (for parallel processes), with the results in the folder of --keep");
  command.add_option("--workers", options.workers, "number of threads; default: one per core")
      ->check(CLI::Range(1, 1024));
  return command.add_option("SCENE", options.target, scene);
}

SceneSpec load_target(const StudyOptions& options) {
  const auto target = resolve_target(options.target);
  if (!target.scene && std::filesystem::is_directory(options.target))
    exit_with({Errc::Missing, target.file.string(), "this is an instrument, and a study needs a scene",
               "write a scene.toml that connects it to a plant"});
  return or_exit(load_scene(target));
}

void publish(const StudyOptions& options, const std::string& text, const Json& json,
             const std::vector<Plot>& page, int columns) {
  fmt::print("{}", options.json ? json.dump(2) + "\n" : text);
  if (options.picture.empty()) return;
  or_exit(write_svg(options.picture, page, columns));
  if (!options.json) fmt::print("plot: {}\n", options.picture);
}

void read_run_plan(const StudyOptions& options, RunPlan& plan) {
  plan.workers = options.workers;
  plan.cache = options.cache;
  read_part(options.part, plan);
}

void add_sweep_options(CLI::App& command, SweepOptions& options) {
  command
      .add_option(
          "--over", options.over,
          "NAME=FROM:TO:COUNT; or FROM:TO:COUNT:log for logarithmic spacing; a unit at the end applies to "
          "FROM and TO. NAME: a control (strength, plant.grip); a gesture (a plain number scales it, a value "
          "with a unit holds it at that value); a parameter of a node (plant.drum.coil.resistance); delay, "
          "rate or oversample. Also solver=NAME,NAME")
      ->take_all();
  command.add_option("--set", options.set, "NAME=VALUE: sets a control; plant.NAME=VALUE: of the plant");
  command.add_option("--duration", options.duration, "duration; of each run; default: the scene's");
  command.add_option("--gain", options.gain,
                     "also run with the actuator weaker and stronger by this gain, such as \"6 dB\"");
  auto* draws = add_number(command, "--draws", options.plan.draws,
                           "number of additional runs with random variations of the plant", 0, 100000);
  command
      .add_option("--within", options.within,
                  "largest deviation of the plant's parameters in the random variations")
      ->capture_default_str()
      ->needs(draws);
  command.add_option("--seed", options.plan.seed, "seed of the random variations")
      ->capture_default_str()
      ->needs(draws);
}

SweepPlan read_plan(const SweepOptions& options, SceneSpec& scene) {
  auto plan = options.plan;
  for (const auto& text : options.over) plan.over.push_back(read_swept(text, scene));
  plan.set = parse_settings(options.set);
  check_swept_once(plan);
  read_option(options.duration, "s", "duration", 1e-3, 3600, scene.duration.value);
  read_run_plan(options, plan);
  read_option(options.within, "", "within", 1e-6, 0.999999, plan.within);
  read_gain(options.gain, plan);
  return plan;
}

SweepMonitor::SweepMonitor(const std::string& name, RunPlan& plan)
    : plan_(plan), progress_("sweep of " + name) {
  using Clock = std::chrono::steady_clock;
  install_signal_handlers();
  plan.stop = interrupted;
  plan.progress = [this, name, start = Clock::now(), shown_s = std::make_shared<double>(0)](double share) {
    const double passed_s = std::chrono::duration<double>(Clock::now() - start).count();
    if (share < 1 && passed_s < *shown_s + 1) return;  // once a second
    *shown_s = passed_s;
    (*progress_)(share, fmt::format("sweep of {}, {}", name, remaining_text(passed_s * (1 / share - 1))));
  };
}

std::optional<int> SweepMonitor::end(std::ptrdiff_t finished, std::ptrdiff_t runs) {
  progress_.reset();
  if (interrupted() && finished < runs) {
    fmt::print(stderr, "interrupted after {} of {} runs; {}\n", finished, runs,
               plan_.cache.empty()
                   ? "no results were saved; with --keep FOLDER an interrupted sweep can be resumed"
                   : "the same command resumes it");
    return kInterrupted;
  }
  if (plan_.parts == 1) return std::nullopt;
  fmt::print(stderr, "part {} of {} is done; {} of {} runs are in {}\n", plan_.part + 1, plan_.parts,
             finished, runs, plan_.cache.string());
  return kDone;
}

}  // namespace tactus::app
