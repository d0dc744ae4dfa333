#include "export/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/cli/console.h"
#include "apps/cli/rig_files.h"
#include "apps/cli/target.h"
#include "engine/core/files.h"
#include "engine/nodes/table.h"
#include "engine/rig/check_rig.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

struct ExportCommandOptions {
  std::string target, kind = "c", number, recurrence, rate = "48 kHz", delay, rig, folder;
  std::vector<std::string> set;
  bool no_guard = false;
  std::optional<std::size_t> ram;
};

const std::vector<std::string> kRecurrences = {"grid", "plain"};  // in the order of RecurrenceForm

/// What the rig says of its outputs.
LimitBook limits_of(const Rig& rig, const LoadedGraph& graph, const ExportOptions& options) {
  auto loaded = graph;
  fit(loaded, rig);
  CompileOptions compiling;
  compiling.sample_rate = options.sample_rate;
  compiling.controls = options.controls;
  const auto plan = or_exit(compile(loaded, standard_nodes(), compiling));
  auto limits = or_exit(wire_rig(rig, *plan)).limits;
  limits.sound_known = true;
  return limits;
}

void take_rig(const ExportCommandOptions& from, const LoadedGraph& graph, ExportOptions& options) {
  LimitBook limits;
  limits.sound_known = false;
  options.limits_from = "built-in limits of outputs without a rig";
  if (!from.rig.empty()) {
    const auto rig = open_rig(from.rig);
    for (const auto& control : rig.controls) options.controls.try_emplace(control.name, control.value);
    if (from.delay.empty() && rig.measured_delay) options.system_delay = *rig.measured_delay;
    limits = limits_of(rig, graph, options);
    options.limits_from = "rig " + fs::path{from.rig}.filename().string();
  }
  if (from.no_guard) return;
  options.limits = [limits](const OutputChannel& channel) { return limits.of({channel.name, channel.use}); };
}

ExportOptions options_of(const ExportCommandOptions& from, const LoadedGraph& graph) {
  ExportOptions options;
  options.target = find_export_target(from.kind);
  options.number = find_number_type(from.number.empty() ? options.target->number : from.number);
  const auto form = std::ranges::find(kRecurrences, from.recurrence);
  options.recurrence = from.recurrence.empty() ? options.target->recurrence
                                               : static_cast<RecurrenceForm>(form - kRecurrences.begin());
  options.sample_rate = parse_rate(from.rate);
  if (!from.delay.empty()) options.system_delay = parse_delay(from.delay);
  options.controls = parse_settings(from.set);
  options.most_bytes = from.ram;
  take_rig(from, graph, options);
  return options;
}

int run_export(const ExportCommandOptions& options) {
  const auto target = resolve_target(options.target, FolderMeans::Instrument);
  if (target.scene)
    exit_with({Errc::BadArgument, "", "'" + options.target + "' is a scene", "export its instrument"},
              kUsage);
  const auto graph = load_graph_leniently(target.file, target.root());
  if (graph.spec == nullptr) throw CommandError{graph.errors};
  const auto files = or_exit(export_graph(graph, standard_nodes(), options_of(options, graph)));
  const auto name = fs::path{files.front().name}.stem().string();
  const fs::path folder = options.folder.empty() ? fs::path{name + "_export"} : fs::path{options.folder};
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed)
    exit_with(
        {Errc::BadFile, folder.string(), "cannot be created: " + failed.message(), "choose another folder"});
  for (const auto& file : files) {
    or_exit(write_file(folder / file.name, file.text));
    fmt::print("{}\n", (folder / file.name).string());
  }
  return kDone;
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  auto [command, options] =
      add_command(app, "export", "Write an instrument as C with static memory", exit_code, run_export);
  command.add_option("GRAPH", options.target, "instrument file, its folder, or its name")->required();
  command
      .add_option("--target", options.kind,
                  "what it is for: c, library (with a CMake file), pd (Pure Data), or a microcontroller")
      ->check(CLI::IsMember(export_target_names()))
      ->capture_default_str();
  command.add_option("--number", options.number, "type of all numbers; default: that of the target")
      ->check(CLI::IsMember(number_type_names()));
  command
      .add_option(
          "--recurrence", options.recurrence,
          "grid: the bits of the engine; plain: recurrences frame by frame; default: that of the target")
      ->check(CLI::IsMember(kRecurrences));
  command.add_option("--rate", options.rate, "sample rate")->capture_default_str();
  command.add_option("--delay", options.delay, "system delay; default: the rig's, or 0 s");
  command.add_option("--rig", options.rig,
                     "rig file; limits of its outputs, its controls and its measured delay");
  command.add_option("--set", options.set, "NAME=VALUE: sets a control");
  command.add_option("-o,--folder", options.folder, "folder for the files; default: NAME_export");
  command.add_option(
      "--ram", options.ram,
      "bytes that the state may take; more is an error that names what is large; default: 7680 on "
      "AVR, of the 8192 of an ATmega2560, else any number");
  command.add_flag("--no-guard", options.no_guard,
                   "leave out the guard: for comparisons, never for an actuator");
  command.footer(
      "Examples:\n  tactus export wall\n  tactus export haptic_drum --number float --recurrence plain -o "
      "drum");
}

}  // namespace tactus::app
