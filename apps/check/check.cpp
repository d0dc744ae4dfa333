#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "apps/cli/backends.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/cli/rig_files.h"
#include "apps/cli/target.h"
#include "apps/cli/warnings.h"
#include "backends/find_device.h"
#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "engine/core/port_name.h"
#include "engine/core/prefixed.h"
#include "engine/graph/file/read_graph.h"
#include "engine/nodes/networks/solver_names.h"
#include "engine/nodes/table.h"
#include "engine/rig/rig.h"
#include "engine/study/stability/stability_check.h"

namespace tactus::app {
namespace {

/// What `tactus check` found.
struct CheckReport : StabilityReport {
  std::string name;
  std::string delay_source;                 ///< where the delay comes from
  std::vector<Error> warnings;              ///< of the files
  std::vector<std::string> highpass_lines;  ///< what the high-passes of the rig do
};

// JSON has no infinity and no NaN: they are written as null.

Json loop_json(const LoopVerdict& loop) {
  const auto& margin = loop.margin;
  return {{"border_factor", margin.border},
          {"border_hz", margin.border_hz},
          {"least_factor_above", margin.up},
          {"largest_factor_below", margin.down},
          {"gain_margin_db", amplitude_to_db(margin.border)},
          {"peak_gain", margin.peak},
          {"peak_hz", margin.peak_hz},
          {"holds_at_every_delay", margin.peak < 1},
          {"more_delay_ms", 1e3 * margin.more_delay_s},
          {"at", loop.at},
          {"through", loop.way},
          {"drive", loop.drive},
          {"joint", loop.wave_port},
          {"integrates", loop.integrates()},
          {"growth_per_s_below_border", loop.growth_below},
          {"growth_per_s_above_border", loop.growth_above}};
}

Json stiff_json(const StiffVerdict& stiff) {
  return {{"name", stiff.path},           {"type", stiff.type},
          {"n_per_m", stiff.stiffness},   {"stable_up_to_n_per_m", stiff.stable_up_to},
          {"border_hz", stiff.border_hz}, {"passive_up_to_n_per_m", known(stiff.passive_up_to)}};
}

Json regime_json(const RegimeVerdict& regime) {
  return {{"regime", regime.name},
          {"held", regime.held},
          {"roots_that_grow", regime.growing},
          {"roots", list_of(regime.roots,
                            [](const LoopRoot& root) -> Json {
                              return {{"hz", root.frequency_hz}, {"growth_per_s", root.growth_per_s}};
                            })},
          {"loops", list_of(regime.loops, loop_json)},
          {"stiff", list_of(regime.stiff, stiff_json)},
          {"crests", regime.unstable_equilibria},
          {"device_damping_n_s_per_m", known(regime.device_damping)}};
}

Json network_json(const NetworkVerdict& network) {
  return {{"name", network.path},
          {"regime", network.regime},
          {"solver", name_of(network.solver)},
          {"spectral_radius", network.radius},
          {"rate_hz", network.rate_hz},
          {"holds_at_every_rate", !network.needed_hz.has_value()},
          {"needs_hz", known(network.needed_hz)},
          {"weakest", network.weakest},
          {"contact_steps", network.contact_steps},
          {"contact_too_deep", network.too_deep},
          {"verdict", name_of(network.stability())}};
}

Json run_json(const ExtremeRun& run) {
  return {{"what", run.what},
          {"rate_hz", run.rate.value},
          {"delay_ms", 1e3 * run.delay_s},
          {"seconds", run.seconds},
          {"peak", run.peak},
          {"before", run.energy_before},
          {"after", run.energy_after},
          {"faults", run.faults},
          {"finite", run.finite},
          {"grew", run.grew},
          {"exploded", run.exploded},
          {"expected_to_hold", run.expected},
          {"as_expected", run.as_expected()}};
}

Json control_json(const ControlVerdict& control) {
  return {{"name", control.control.name},       {"value", control.control.value},
          {"low", control.control.range.low},   {"high", control.control.range.high},
          {"holds_at_low", control.stable_low}, {"holds_at_high", control.stable_high},
          {"border", known(control.border)}};
}

Json gesture_json(const GestureVerdict& gesture) {
  return {{"control", gesture.control},
          {"value", gesture.value},
          {"seconds", gesture.seconds},
          {"verdict", name_of(gesture.stability)}};
}

Json doubt_json(const Doubt& doubt) { return {{"reason", doubt.reason}, {"remedy", doubt.remedy}}; }

Json held_json(const HeldVerdict& held) {
  Json json{{"input", held.input},
            {"added", held.level},
            {"alternates", held.alternates},
            {"verdict", name_of(held.stability)}};
  if (held.place) json["place"] = *held.place;
  return json;
}

constexpr const char* kPlayIt = "play it with these settings, for as long as you mean to use it";

/// Why a run leaves the verdict undecided.
std::string not_as_predicted(const ExtremeRun& run) {
  return fmt::format("not as predicted: {} {}", run.what,
                     run.exploded     ? "grew until an output, ahead of its guard, was beyond 120 dB"
                     : !run.finite    ? "gave values that are not finite"
                     : run.faults > 0 ? "had faults"
                     : run.expected   ? "grew"
                                      : "did not grow");
}

/// Doubts of the analysis, and runs that contradict it.
Json undecided_json(const StabilityReport& report) {
  Json list = list_of(report.verdict.doubts, doubt_json);
  for (const auto& run : report.runs)
    if (!run.as_expected()) list.push_back({{"reason", not_as_predicted(run)}, {"remedy", kPlayIt}});
  return list;
}

Json event_json(const EventPlace& event) {
  return {{"name", event.path},
          {"type", event.type},
          {"hold_s", known(event.hold_s)},
          {"on_loop", event.on_loop}};
}

Json open_json(const OpenPair& open) {
  return {
      {"input", open.input}, {"output", open.output}, {"peak_gain", open.peak}, {"peak_hz", open.peak_hz}};
}

/// Rows of cells; the first row is the heading.
void print_table(const std::vector<std::vector<std::string>>& rows) {
  if (rows.size() < 2) return;
  std::vector<std::string> lines(rows.size());
  for (std::size_t column = 0; column < rows.front().size(); ++column) {
    std::size_t width = 0;
    for (const auto& row : rows) width = std::max(width, row[column].size());
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const bool last = column + 1 == rows.front().size();
      lines[r] += "  " + rows[r][column] + (last ? "" : std::string(width - rows[r][column].size(), ' '));
    }
  }
  fmt::print("\n{}\n", fmt::join(lines, "\n"));
}

const char* yes(bool is) { return is ? "yes" : "no"; }
std::string decibels(double factor) {
  const double db = amplitude_to_db(factor);
  return std::isfinite(db) ? fmt::format("{:.1f} dB", db) : "unlimited";
}

void print_regimes(const StabilityVerdict& verdict) {
  std::vector<std::vector<std::string>> loops{{"operating point", "held", "loop cut at", "gain margin", "at",
                                               "largest gain", "delay margin", "network port", "integrates"}};
  std::vector<std::vector<std::string>> stiff{
      {"operating point", "held", "force", "stiffness", "stable up to", "passive up to"}};
  for (const auto& regime : verdict.regimes) {
    for (const auto& loop : regime.loops)
      loops.push_back({regime.name, yes(regime.held), loop.at, decibels(loop.margin.border),
                       prefixed(loop.margin.border_hz, "Hz"), decibels(loop.margin.peak),
                       prefixed(loop.margin.more_delay_s, "s"), yes(loop.wave_port), yes(loop.integrates())});
    for (const auto& one : regime.stiff)
      stiff.push_back({regime.name, yes(regime.held), one.path, one.with_unit(one.stiffness),
                       one.with_unit(one.stable_up_to),
                       one.passive_up_to ? one.with_unit(*one.passive_up_to) : "-"});
  }
  print_table(loops);
  print_table(stiff);
}

void print_networks(const StabilityVerdict& verdict) {
  std::vector<std::vector<std::string>> rows{
      {"network", "operating point", "solver", "spectral radius", "steps at", "needs", "least stable mode"}};
  for (const auto& network : verdict.networks)
    rows.push_back({network.path, network.regime, name_of(network.solver),
                    fmt::format("{:.10g}", network.radius), prefixed(network.rate_hz, "Hz"),
                    network.needed_hz ? prefixed(*network.needed_hz, "Hz") : "any rate", network.weakest});
  print_table(rows);
}

void print_controls(const StabilityVerdict& verdict) {
  std::vector<std::vector<std::string>> rows{
      {"control", "lowest", "stable there", "highest", "stable there", "limit"}};
  for (const auto& one : verdict.controls) {
    const auto text = [&](double si) { return std::isfinite(si) ? in_unit(si, one.control.unit) : "-"; };
    rows.push_back({one.control.name, text(one.control.range.low), yes(one.stable_low),
                    text(one.control.range.high), yes(one.stable_high),
                    one.border ? text(*one.border) : "none"});
  }
  print_table(rows);
  rows = {{"control set by a gesture", "to", "at", "verdict"}};
  for (const auto& gesture : verdict.gestures)
    rows.push_back({gesture.control, in_unit(gesture.value, gesture.unit), prefixed(gesture.seconds, "s"),
                    name_of(gesture.stability)});
  print_table(rows);
}

void print_runs(const std::vector<ExtremeRun>& runs) {
  std::vector<std::vector<std::string>> rows{{"simulation run", "rate", "delay", "duration",
                                              "peak of the drives", "energy first", "and last", "predicted",
                                              "result"}};
  for (const auto& run : runs) {
    const auto* const unit = run.linear ? "" : "J";
    rows.push_back({run.what, prefixed(run.rate.value, "Hz"), prefixed(run.delay_s, "s"),
                    prefixed(run.seconds, "s"), fmt::format("{:.3g} FS", run.peak),
                    prefixed(run.energy_before, unit), prefixed(run.energy_after, unit),
                    run.expected ? "stable" : "grows",
                    !run.finite      ? "not finite"
                    : run.exploded   ? "beyond 120 dB"
                    : run.grew       ? "grows"
                    : run.faults > 0 ? fmt::format("{} faults", run.faults)
                                     : "stable"});
  }
  print_table(rows);
}

std::string counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// One line of what was checked.
std::string checked_text(const CheckReport& report) {
  const auto& verdict = report.verdict;
  std::size_t loops = 0;
  for (const auto& regime : verdict.regimes) loops += regime.loops.size();
  std::vector<std::string> parts{counted(verdict.regimes.size(), "operating point"), counted(loops, "loop")};
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) parts.push_back(counted(count, what));
  };
  add(verdict.networks.size(), "network");
  add(verdict.controls.size(), "control");
  add(verdict.gestures.size(), "gesture");
  parts.push_back(report.runs.empty() ? "no simulation (--quick)"
                                      : counted(report.runs.size(), "simulation run"));
  return fmt::format("checked: {}", fmt::join(parts, ", "));
}

/// Every number of it.
Json check_json(const CheckReport& report) {
  const auto& verdict = report.verdict;
  return {
      {"name", report.name},
      {"verdict", name_of(report.stability())},
      {"holds", report.stability() == Stability::Stable},
      {"undecided", undecided_json(report)},
      {"outside_known", verdict.outside_known},
      {"sample_rate_hz", verdict.rate.value},
      {"delay_ms", 1e3 * verdict.delay_s},
      {"delay_from", report.delay_source},
      {"words", describe(verdict)},
      {"output_highpass", report.highpass_lines},
      {"warnings", list_of(report.warnings, [](const Error& warning) -> Json { return to_string(warning); })},
      {"regimes", list_of(verdict.regimes, regime_json)},
      {"networks", list_of(verdict.networks, network_json)},
      {"controls", list_of(verdict.controls, control_json)},
      {"gestures", list_of(verdict.gestures, gesture_json)},
      {"events", list_of(verdict.events, event_json)},
      {"open", list_of(verdict.open, open_json)},
      {"held", list_of(verdict.held, held_json)},
      {"runs", list_of(report.runs, run_json)}};
}

/// The verdict, what fails, and with `verbose` every table.
void print(const CheckReport& report, bool verbose) {
  const auto& verdict = report.verdict;
  const bool by_itself = report.stability() == Stability::Stable && !verdict.outside_known;
  fmt::print("{}{}\n\n", name_of(report.stability()),
             by_itself ? " by itself; the loop through the plant is not known" : "");
  const auto sentences = describe(verdict);
  fmt::print("{}: {} ({})\n", report.name, sentences.front(), report.delay_source);
  for (std::size_t i = 1; i < sentences.size(); ++i) fmt::print("  {}\n", sentences[i]);
  for (const auto& run : report.runs)
    if (!run.as_expected()) fmt::print("  {}; {}\n", not_as_predicted(run), kPlayIt);
  for (const auto& line : report.highpass_lines) fmt::print("  {}\n", line);
  for (const auto& warning : report.warnings) fmt::print("  {}\n", text_of_warning(warning));
  fmt::print("{}{}\n", checked_text(report), verbose ? "" : "; --verbose prints the tables");
  if (!verbose) return;
  print_regimes(verdict);
  print_networks(verdict);
  print_controls(verdict);
  print_runs(report.runs);
}

struct CheckOptions {
  std::string target, rate, delay, rig;
  std::string hand_damping = "2 N s/m", hand_mass = "6 g", push = "10 N";
  std::string device_mass = "50 g", device_damping = "0.1 N s/m";
  std::vector<std::string> set;
  bool quick = false, json = false, verbose = false;
};

/// The scene or the instrument to check, and how.
struct CheckJob {
  std::optional<LoadedScene> scene;
  std::optional<LoadedGraph> instrument;
  std::optional<Rig> rig;
  StabilityOptions options;

  StabilitySubject subject() const {
    return {scene ? &*scene : nullptr, instrument ? &*instrument : nullptr, &standard_nodes()};
  }
};

/// Gives its name.
std::string load(const CheckOptions& options, CheckJob& job) {
  const auto target =
      resolve_target(options.target, options.rig.empty() ? FolderMeans::Scene : FolderMeans::Instrument);
  if (target.scene) {
    job.scene = load_scene_leniently(target);
    if (!job.scene->scene) throw CommandError{job.scene->errors, kBadFile};
    return job.scene->scene->name;
  }
  job.instrument = load_graph_leniently(target.file, target.root());
  if (job.instrument->spec == nullptr) throw CommandError{job.instrument->errors, kBadFile};
  return job.instrument->spec->name;
}

/// The rate of its device, and the card's high-passes, which are part of the loops of an instrument; a scene
/// has a plant of its own.
void read_rig(const CheckOptions& options, CheckJob& job) {
  if (options.rig.empty()) return;
  if (job.scene)
    exit_with({Errc::BadArgument, "--rig", "a scene has its own plant and delay",
               "omit --rig, or check the instrument of the scene"});
  job.rig = open_rig(options.rig);
  fit(*job.instrument, *job.rig);
  const auto& device = job.rig->device;
  auto& rate = job.options.world.rate;
  if (!rate) rate = device.rate;
  if (!rate && is_haptic(backend_of(device.output))) rate = kHapticRate;
  for (const auto& output : job.rig->outputs)
    if (output.highpass) job.options.world.output_highpass[output.name] = *output.highpass;
}

/// What the high-passes do to the forces of this instrument.
std::vector<std::string> highpass_lines(const CheckJob& job, const StabilityVerdict& verdict) {
  std::vector<std::string> lines;
  for (const auto& [output, highpass] : job.options.world.output_highpass)
    lines.push_back(fmt::format("output '{}' passes a high-pass of {} (rig): {}", output,
                                prefixed(highpass.value, "Hz"), decay_text(highpass)));
  std::set<std::string> held;
  for (const auto& regime : verdict.regimes)
    for (const auto& stiff : regime.stiff) held.insert("'" + stiff.path + "'");
  // Where the plant is not known: an output that answers a slow motion most.
  for (const auto& pair : verdict.open) {
    const auto highpass = job.options.world.output_highpass.find(port_of(pair.output));
    if (highpass != job.options.world.output_highpass.end() && pair.peak_hz < highpass->second.value)
      held.insert(fmt::format("'{}' (from '{}')", pair.output, pair.input));
  }
  if (!lines.empty() && !held.empty())
    lines.push_back(fmt::format("warning: {} must hold a force, which leaks away: use a DC-coupled output",
                                fmt::join(held, ", ")));
  return lines;
}

/// --delay, else the scene's, else the measured one of the rig, else the longest of what was tested. Gives
/// its source.
std::string choose_delay(const CheckOptions& options, CheckJob& job) {
  auto& world = job.options.world;
  if (!options.delay.empty()) {
    world.delay = parse_delay(options.delay);
    return "delay from --delay";
  }
  if (job.scene) {
    world.delay = job.scene->scene->delay;
    return "delay of the scene";
  }
  if (!options.rig.empty()) {
    const auto& rig = *job.rig;
    if (!rig.measured_delay)
      exit_with({Errc::Missing, options.rig, "this rig has no delay",
                 delay_remedy(rig.device.output, options.rig) +
                     "; write it into the rig (measured, under [delay]), or give --delay"},
                kBadFile);
    world.delay = *rig.measured_delay;
    for (const auto& control : rig.controls) world.set.try_emplace(control.name, control.value.si);
    return "delay of the rig";
  }
  const auto& tested = job.instrument->spec->tested;
  if (!tested) return "delay not known";
  world.delay = Seconds{tested->high};
  return "longest delay that the instrument was tested with";
}

/// Gives the source of the delay.
std::string read_options(const CheckOptions& options, CheckJob& job) {
  auto& world = job.options.world;
  if (!options.rate.empty()) world.rate = parse_rate(options.rate);
  const auto size = [](const std::string& text, const char* unit, const char* option) {
    return parse_option(text, unit, option, kAboveZero);
  };
  job.options.hand = {size(options.hand_damping, "N s/m", "hand-damping"),
                      size(options.hand_mass, "kg", "hand-mass")};
  world.device = {size(options.device_mass, "kg", "device-mass"),
                  size(options.device_damping, "N s/m", "device-damping")};
  job.options.push = size(options.push, "N", "push");
  world.set = parse_settings(options.set);
  read_rig(options, job);
  return choose_delay(options, job);
}

/// Of the instrument and its plant, if that is not an assumed device.
std::vector<Error> warnings_of(const CheckJob& job) {
  const auto built = or_exit(build_world(job.subject(), job.options.world));
  auto warnings = built.instrument->plan().warnings;
  if (job.instrument) return warnings;
  const auto& of_plant = built.plant->plan().warnings;
  warnings.insert(warnings.end(), of_plant.begin(), of_plant.end());
  return warnings;
}

int run_check(const CheckOptions& options) {
  CheckJob job;
  CheckReport report;
  report.name = load(options, job);
  report.delay_source = read_options(options, job);
  {
    Progress progress{"analysing the loops"};
    const auto show = [&](const std::string& what, double share) { progress(share, what); };
    static_cast<StabilityReport&>(report) =
        or_exit(check_stability(job.subject(), job.options, options.quick, show));
  }
  report.warnings = warnings_of(job);
  report.highpass_lines = highpass_lines(job, report.verdict);
  options.json ? print_json(check_json(report)) : print(report, options.verbose);
  return report.stability() == Stability::Stable ? kDone : kNo;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(
      app, "check", "Check whether an instrument or scene is stable, and what would become unstable first",
      exit_code, run_check);
  command
      .add_option(
          "FILE", options.target,
          "instrument or scene file; for a folder, its scene.toml, or its instrument.toml if --rig is given")
      ->required();
  command.add_option("--rate", options.rate,
                     "sample rate; default: that of the scene or of the rig's device, or 48 kHz");
  command.add_option("--delay", options.delay, "system delay; default: the scene's or the rig's");
  command.add_option("--rig", options.rig,
                     "rig file: rate, delay, and high-passes of its outputs (output_highpass)");
  command.add_option("--set", options.set, "NAME=VALUE: sets a control");
  for (const auto& [name, value, help] :
       {std::tuple{"--hand-damping", &options.hand_damping, "damping added to the device by a fingertip"},
        {"--hand-mass", &options.hand_mass, "mass added to the device by a fingertip"},
        {"--push", &options.push, "contact force assumed in the analysis of a contact that touches"},
        {"--device-mass", &options.device_mass,
         "moving mass of the device; assumed for an instrument without a scene"},
        {"--device-damping", &options.device_damping,
         "viscous damping of the device; assumed for an instrument without a scene"}})
    command.add_option(name, *value, help)->capture_default_str();
  command.add_flag("--quick", options.quick, "analyse the graph only; do not simulate");
  command.add_flag("--verbose", options.verbose,
                   "also print tables of all loops, networks, controls and simulation runs");
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Examples:\n  tactus check instruments/haptic_drum\n  tactus check my_wall.toml --delay \"1 ms\" "
      "--device-mass \"30 g\"\n  tactus check my_scene.toml --quick --json\n\nExit code 1: unstable or "
      "undecided.");
}

}  // namespace tactus::app
