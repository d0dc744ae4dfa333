#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "apps/cli/console.h"
#include "apps/play/live/plan.h"
#include "apps/play/play_report.h"
#include "engine/scene/measures/measure.h"

namespace tactus::app {
namespace {

struct PlayOptions : LiveOptions {
  std::string folder = "out";
  std::vector<std::string> show;
  bool all_signals = false;
  const CLI::App* command = nullptr;
};

/// What is reported of a played scene, for machines and for people.
struct Report {
  const PlayedScene& played;
  std::vector<ReportSection> sections;
  std::vector<ExpectationResult> outcomes;

  bool passed() const {
    return played.recording.faults.empty() &&
           std::all_of(outcomes.begin(), outcomes.end(),
                       [](const ExpectationResult& outcome) { return outcome.holds || !outcome.reached; });
  }
  double delay_ms() const { return 1e3 * played.recording.delay_frames / played.recording.sample_rate.value; }
  double times_real_time() const { return played.recording.seconds() / played.recording.run_seconds; }
};

Json outcome_json(const ExpectationResult& outcome) {
  return {{"name", outcome.name},
          {"value", known(outcome.reached, outcome.value)},
          {"unit", outcome.unit},
          {"wanted", outcome.wanted},
          {"holds", known(outcome.reached, outcome.holds)}};
}

Json report_json(const Report& report) {
  const auto& recording = report.played.recording;
  Json json{{"scene", report.played.scene.name}, {"sample_rate_hz", recording.sample_rate.value},
            {"delay_ms", report.delay_ms()},     {"duration_s", recording.seconds()},
            {"run_s", recording.run_seconds},    {"real_time_factor", report.times_real_time()}};
  for (const auto& section : report.sections) json.update(section.json);
  json.update({{"faults", faults_json(recording.faults)},
               {"bad_input_samples", recording.bad_inputs},
               {"guard", guard_json(recording.guard, recording.sample_rate)},
               {"ports", ports_json(recording.ports)},
               {"network_solvers", networks_json(report.played.networks)},
               {"expected", list_of(report.outcomes, outcome_json)}});
  return json;
}

/// A heading with its lines beside it.
void print_lines(const char* heading, const std::string& lines) {
  std::istringstream stream{lines};
  for (std::string line; std::getline(stream, line); heading = "")
    fmt::print("  {:<18}  {}\n", heading, line);
}

void print(const ExpectationResult& outcome) {
  if (!outcome.reached)
    return fmt::print("    --    {:16} not reached: the run ended before its time window did\n",
                      outcome.name);
  fmt::print("    {}  {:16} {:.4g}{}, {}\n", outcome.holds ? "ok  " : "FAIL", outcome.name, outcome.value,
             outcome.unit.empty() ? "" : " " + outcome.unit, outcome.wanted);
}

void print(const Report& report) {
  const auto& [scene, recording, networks, inputs] = report.played;
  fmt::print("{}\n{}{}\n", scene.name, scene.about, scene.about.empty() ? "" : "\n");
  fmt::print(
      "  played              {:g} s at {:g} Hz with {:g} ms of delay, in {:.2f} s: {:.0f} times real time\n",
      recording.seconds(), recording.sample_rate.value, report.delay_ms(), recording.run_seconds,
      report.times_real_time());
  print_lines("inputs", inputs);
  for (const auto& section : report.sections) fmt::print("{}", section.text);
  print_guard(recording.guard, recording.sample_rate);
  print_ports(recording.ports);
  print_networks(networks);
  print_faults(recording);
  if (!report.outcomes.empty()) fmt::print("\n  expectations of this scene\n");
  for (const auto& outcome : report.outcomes) print(outcome);
}

/// "", "8080" or "ADDRESS:8080".
bool is_port(const std::string& text) {
  const auto port = text.substr(text.rfind(':') + 1);
  return port.find_first_not_of("0123456789") == std::string::npos && (text.empty() || !port.empty());
}

void add_live_options(CLI::App& command, LiveOptions& options) {
  auto* group = command.add_option_group("on a sound card");
  add_device_options(*group, options, "rig file: device, channels, actuators, sensors, measured delay");
  for (const auto& [name, channels, help] :
       {std::tuple{"--inputs", &options.in_channels,
                   "channels of the device for the inputs; such as --inputs 2,5"},
        {"--outputs", &options.out_channels, "channels of the device for the outputs"}})
    group->add_option(name, *channels, help)->delimiter(',')->check(CLI::Range(1, 1024));
  add_number(*group, "--periods", options.periods, "blocks in the driver's buffer", 1, 64);
  group->add_option("--pad-delay", options.pad_delay,
                    "add delay so that the system delay is this long in every session, such as \"20 ms\"");
  group->add_option("--record", options.record, "record sensors, drives and controls to this WAV file");
  group->add_option("--save-rig", options.save_rig,
                    "ask what is connected to each channel, and write the answers to this rig file");
  group->add_flag("--learn{*}", options.learn,
                  "set a sensor's sensitivity from five soft hits; default NAME: the first sensor");
  group
      ->add_option("--midi", options.midi,
                   "MIDI backend: alsa, core, winmm, or jack beside a card over JACK; default: the system's")
      ->check(CLI::IsMember({"alsa", "jack", "core", "winmm"}));
  group
      ->add_option_function<std::vector<std::string>>(
          "--hid", [&options](const auto& device) { options.hid = device.empty() ? "" : device.front(); },
          "joysticks, gamepads and pedals move controls: those whose name contains this, or all")
      ->type_name("[NAME]")
      ->expected(0, 1);
  group
      ->add_option_function<std::vector<std::string>>(
          "--midi-out", [&options](const auto& port) { options.midi_out = port.empty() ? "" : port.front(); },
          "send events and controls as MIDI messages, to the output of this name or to a port of the "
          "program's own")
      ->type_name("[PORT]")
      ->expected(0, 1);
  group->add_flag("--listen", options.listen,
                  "simulate a scene in real time and play its sound through the sound card");
  group->add_option("--osc", options.osc,
                    "remote control by OSC at this port, such as 9000; for clients of other hosts with the "
                    "address of this one, such as 0.0.0.0:9000");
  group->add_flag("--osc-arm", options.osc_arm, "OSC clients of other hosts may arm the drives");
  group
      ->add_option_function<std::vector<std::string>>(
          "--panel", [&options](const auto& at) { options.panel = at.empty() ? "" : at.front(); },
          "panel in a browser, at this port or any free one; for other hosts with the address of this one, "
          "such as 0.0.0.0:8080")
      ->type_name("[ADDRESS:][PORT]")
      ->expected(0, 1)
      ->check([](const std::string& at) {
        return is_port(at) ? "" : "'" + at + "' is no port: put FILE before --panel, or write --panel=8080";
      });
  group
      ->add_option("--serial", options.serial,
                   "sensors at a serial port set controls, such as /dev/ttyACM0 or /dev/ttyUSB0@57600")
      ->allow_extra_args(false);
  group->add_flag("--panel-arm", options.panel_arm, "panels on other hosts may arm the drives");
  group->add_flag("--no-browser", options.no_browser, "print the link of the panel and do not open it");
  group->add_flag("--arm", options.arm, "start with the drives armed, without waiting for a and Enter");
  group->add_flag("--shared-port", options.shared_port,
                  "another program may write to the ports of drives too: no guard limits the sum");
  group->add_flag(
      "--awake", options.awake,
      "processors do not fall asleep between blocks: shorter computing times, more power (Linux)");
  group->add_flag("--yes", options.yes, "answer every question with its default value");
  group->add_flag("--force", options.force, "overwrite files");
}

/// Options for sound cards only must not be given without one.
void check_card_options(const CLI::App& command) {
  for (const auto* option : {"--record", "--save-rig", "--learn", "--midi", "--pad-delay", "--inputs",
                             "--outputs", "--periods", "--arm", "--shared-port", "--awake", "--osc",
                             "--osc-arm", "--panel", "--panel-arm", "--serial", "--hid", "--midi-out"})
    if (command.count(option) > 0)
      exit_with({Errc::BadArgument, option, "needs a sound card", "give --device, --backend or --rig too"});
}

int run_play(const PlayOptions& options) {
  if (options.live()) return play_live(options);
  check_card_options(*options.command);
  const auto target = resolve_target(options.target);
  const auto played = play_file(target, options);
  auto outcomes = or_exit(check_expectations(played.scene, played.recording));
  std::optional<PlayedScene> compared;
  if (played.scene.compare) compared = play_file(target, options, &played.scene.compare->set);
  const Report report{played, sections_of(played, compared ? &*compared : nullptr), std::move(outcomes)};
  auto json = report_json(report);
  auto shown = shown_part(options.show, played);
  shown.all = options.all_signals;
  auto written = write_files(options.folder, played, compared ? &*compared : nullptr, shown);
  const auto report_file = base_of(options.folder, played) + ".json";
  or_exit(write_json(report_file, json));
  written.push_back(report_file + "  this report, with the actions of the guard");
  if (options.json) {
    json["written"] = written;
    print_json(json);
  } else {
    print(report);
    fmt::print("\n  written\n    {}\n", fmt::join(written, "\n    "));
  }
  return report.passed() && !played.recording.guard.faded() ? kDone : kNo;
}

}  // namespace

void add_play(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(
      app, "play", "Play an instrument on a sound card, or a scene in simulation", exit_code, run_play);
  options.command = &command;
  command
      .add_option("FILE", options.target,
                  "instrument or scene file; for a folder, its scene.toml in simulation, its "
                  "instrument.toml on a sound card or with --in")
      ->required();
  add_player_options(command, options);
  command.add_option(
      "--in", options.in,
      "what the inputs of an instrument receive: in simulation a WAV file (channel k feeds the "
      "k-th input), test-signal (default), silence, or with --listen keyboard (the space key "
      "strikes)");
  command.add_option("--folder", options.folder, "folder for the files: sound, signals, plot and report")
      ->check(writable_folder())
      ->capture_default_str();
  command
      .add_option("--show", options.show, "FROM TO: time range of the plot, such as --show \"2 s\" \"3 s\"")
      ->expected(2);
  command.add_flag("--all-signals", options.all_signals, "plot every signal, not only the first five plots");
  add_live_options(command, options);
  command.footer(
      "Examples:\n  tactus play instruments/haptic_drum\n  tactus play instruments/haptic_drum --device "
      "jack:system\n  tactus play instruments/haptic_drum --delay \"40 ms\" --set strength=0.5\n  tactus "
      "play my.toml --listen\n  tactus play my.toml --in hits.wav\n  tactus "
      "play instruments/haptic_drum/galloping.toml --show \"2 s\" \"3 s\"\nExit code 1: an expectation of "
      "the scene was not met.");
}

}  // namespace tactus::app
