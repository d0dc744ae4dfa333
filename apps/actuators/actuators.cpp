#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

#include "apps/actuators/actuator_need.h"
#include "apps/actuators/actuator_text.h"
#include "apps/actuators/scene_verdict.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"

namespace tactus::app {
namespace {

struct ActuatorOptions {
  NeedOptions need;
  std::string scene;
  bool json = false, sources = false;
};

struct DemandFigure {
  const char *what, *unit;
  double value;
};

std::vector<DemandFigure> figures_of(const Demand& demand) {
  std::vector<DemandFigure> known;
  const auto add = [&](const char* what, const char* unit, const std::optional<double>& value) {
    if (value) known.push_back({what, unit, *value});
  };
  add("largest force on the player", "N", demand.force);
  add("largest torque on the player", "N m", demand.torque);
  add("largest force on the case of its actuator", "N", demand.case_force);
  add("travel to either side", "m", demand.travel);
  add("angle to either side", "rad", demand.angle);
  return known;
}

void print_demand(const Demand& demand) {
  fmt::print("{}\n", demand.scene);
  for (const auto& drive : demand.drives)
    fmt::print("  '{}': nine tenths of its energy between {} and {}\n", drive.name,
               number_text(drive.band().low, "Hz"), number_text(drive.band().high, "Hz"));
  for (const auto& [what, unit, value] : figures_of(demand))
    fmt::print("  {}: {}\n", what, number_text(value, unit));
  if (demand.senses) fmt::print("  the instrument reads a sensor\n");
  if (demand.stability)
    fmt::print("  with the plant of the scene: {} (see tactus check)\n", name_of(*demand.stability));
  fmt::print("\n");
}

/// What is wrong with some files is reported beside the list of the others.
int end_with(const std::vector<Error>& errors) {
  if (errors.empty()) return kDone;
  print_note(to_string(errors));
  return kNo;
}

int run_actuators(const ActuatorOptions& options) {
  const auto need = need_of(options.need);
  auto [all, errors] = load_actuators();
  if (all.empty() && errors.empty())
    exit_with({Errc::BadFile, "actuators", "the figures of actuators are not installed",
               "install the shipped instruments"},
              kBadFile);
  auto demand = options.scene.empty() ? std::nullopt : std::optional{demand_of(options.scene)};
  if (demand && !demand->senses && !demand->force && !demand->torque)
    demand->case_force = force_on_case(all, *demand);
  const auto sensors =
      demand || need.any() ? std::erase_if(all, [](const Actuator& one) { return one.figures.sensor; }) : 0;
  Json json{{"actuators", Json::array()}};
  std::vector<std::string> notes;
  std::vector<const Actuator*> shown;
  int left_out = 0;
  for (const auto& actuator : all) {
    const auto found = match(actuator, need);
    auto entry = json_of(actuator.figures);
    entry["lacks"] = found.lacks;
    entry["unknown"] = found.unknown;
    entry["remarks"] = found.remarks;
    const auto verdict = demand ? std::optional{compare(actuator, *demand)} : std::nullopt;
    if (verdict) {
      entry["objections"] = verdict->against;
      entry["at_the_edge"] = verdict->close;
      entry["not_compared"] = verdict->open;
    }
    json["actuators"].push_back(std::move(entry));
    if (!found.lacks.empty()) {
      ++left_out;
      continue;
    }
    shown.push_back(&actuator);
    const auto note = [&](const std::string& text) {
      notes.push_back(fmt::format("{}: {}", actuator.figures.name, text));
    };
    if (!found.unknown.empty()) note(fmt::format("not compared: {}", fmt::join(found.unknown, ", ")));
    for (const auto& remark : found.remarks) note(remark);
    if (verdict) note(verdict->text());
  }
  if (options.json) {
    if (!errors.empty()) json["errors"] = errors_json(errors);
    print_json(json);
    return end_with(errors);
  }
  if (demand) print_demand(*demand);
  print_table(shown);
  if (options.sources)
    for (const auto* actuator : shown) print_sources(*actuator);
  if (left_out > 0)
    fmt::print("{} more {} not have what is asked for\n", left_out, left_out == 1 ? "does" : "do");
  if (sensors > 0) fmt::print("sensors are left out\n");
  if (!notes.empty()) fmt::print("\n");
  for (const auto& note : notes) fmt::print("{}\n", note);
  if (!options.sources)
    fmt::print(
        "\n~: a judgement; -: none, or not one number; --sources prints each figure in words, and where it "
        "comes from\n");
  return end_with(errors);
}

}  // namespace

void add_actuators(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(
      app, "actuators", "List actuators with price, force, band, excursion and resolution, or those that fit",
      exit_code, run_actuators);
  command.add_option("--force", options.need.force, "force that it must have, such as \"2 N\"");
  command.add_option("--band", options.need.band, "frequency that it must move at, or two: \"20 Hz,200 Hz\"");
  command.add_option("--excursion", options.need.excursion, "excursion to either side, such as \"3 mm\"");
  command.add_option("--resolution", options.need.resolution, "of its own sensor, such as \"0.2 mm\"");
  command.add_option("--price", options.need.price, "US $ that it may cost, such as 50");
  command.add_option(
      "--for", options.scene,
      "a scene: which actuators render it, by the spectrum of its drives, its force, travel and "
      "sensor, its stability and the models of the drive guard");
  command.add_flag("--sources", options.sources, "also print where each figure comes from");
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Examples:\n  tactus actuators\n  tactus actuators --force \"1 N\" --price 50\n"
      "  tactus actuators --for instruments/haptic_drum");
}

}  // namespace tactus::app
