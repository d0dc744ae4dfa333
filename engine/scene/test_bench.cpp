#include "engine/scene/test_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace tactus {
namespace {

using Kind = BenchInputs::Kind;

/// The sources of strikes: two per second, and those of the control.
constexpr const char* kStrikes = R"toml(
bench_clock = { type = "sine", frequency = "2 Hz" }
bench_beat  = { type = "threshold", in = "beats * bench_clock", level = 0.01, hysteresis = 0.01 }
bench_key   = { type = "threshold", in = "strike", level = 0.5 }
bench_burst = { type = "decay", trigger = "max(bench_beat, bench_key)", time = "3 ms" }
bench_noise = { type = "noise", level = 0.5 }
)toml";
constexpr const char* kStruck = "bench_noise * (bench_burst + 0.0002)";

/// A slow sine for an input with a unit.
struct Motion {
  Dimension of;
  const char* amplitude;
};
constexpr Motion kMotions[] = {
    {{.metre = 1}, "10 mm"},
    {{.metre = 1, .second = -1}, "0.1 m/s"},
    {{.radian = 1}, "30 deg"},
};
constexpr const char* kMotionFrequency = "0.5 Hz";

/// "10 mm"; of other units 1 in SI.
std::string amplitude_of(const PortSpec& input) {
  for (const auto& motion : kMotions)
    if (motion.of == input.dimension) return motion.amplitude;
  return "1 " + to_string(input.dimension);
}

enum class Receives { Strikes, Motion, File, Silence };

Receives received_by(const PortSpec& input, int number, const BenchInputs& inputs) {
  const bool strikes = inputs.kind == Kind::TestSignal || inputs.kind == Kind::Keyboard;
  if (strikes && to_string(input.dimension).empty()) return Receives::Strikes;
  if (inputs.kind == Kind::TestSignal) return Receives::Motion;
  return inputs.kind == Kind::File && number < inputs.channels ? Receives::File : Receives::Silence;
}

/// What one input receives, as an expression, with the node that it needs.
struct Signal {
  std::string expression;
  std::string node{};
};

Signal signal_of(const PortSpec& input, int number, const BenchInputs& inputs) {
  const auto unit = "1 " + to_string(input.dimension);
  const auto name = fmt::format("bench_input_{}", number + 1);
  switch (received_by(input, number, inputs)) {
    case Receives::Strikes:
      return {kStruck};
    case Receives::Motion:
      return {name, fmt::format("{} = {{ type = \"sine\", frequency = \"{}\", level = \"{}\" }}\n", name,
                                kMotionFrequency, amplitude_of(input))};
    case Receives::File:
      return {name, fmt::format("{} = {{ type = \"sample\", file = '{}', channel = {}, trigger = 1, level = "
                                "\"{}\" }}\n",
                                name, inputs.file.filename().generic_string(), number + 1, unit)};
    case Receives::Silence:
      break;
  }
  return {"0 * " + unit};
}

std::string plant_text(const GraphSpec& instrument, const BenchInputs& inputs) {
  std::string nodes = kStrikes, outputs;
  for (std::size_t n = 0; n < instrument.inputs.size(); ++n) {
    const auto& input = instrument.inputs[n];
    const auto signal = signal_of(input, static_cast<int>(n), inputs);
    nodes += signal.node;
    outputs += fmt::format("{} = {{ from = \"{}\" }}\n", input.name, signal.expression);
  }
  return fmt::format(
      "format = 1\nname = \"test bench\"\n[controls]\nstrike = {{ value = 0, range = [0, 1] }}\n"
      "beats = {{ value = {}, range = [0, 1] }}\n[nodes]{}[outputs]\n{}",
      inputs.kind == Kind::TestSignal ? 1 : 0, nodes, outputs);
}

// ---- a keyboard

bool takes_notes(const GraphSpec& instrument) {
  return std::ranges::any_of(
      instrument.controls, [](const ControlSpec& control) { return control.control.midi != MidiRole::None; });
}

constexpr double kKeys[] = {60, 64, 67, 72};  // a chord of C major
constexpr double kVelocity = 0.7, kEvery_s = 0.5, kHeld_s = 0.4, kPulse_s = 0.01;

/// What the keyboard does to a control: steps between values of its range.
Gesture played_notes(const ControlSpec& control, Seconds duration) {
  Gesture gesture;
  gesture.name = "bench_" + control.name;
  gesture.at = control.at;
  gesture.curve = Gesture::Curve::Step;
  gesture.bare = true;
  const auto add = [&](double time_s, double value) {
    gesture.points.push_back(
        {time_s, std::clamp(value, control.control.range.low, control.control.range.high)});
  };
  const auto pulse = [&](double time_s) {
    add(time_s, 1);
    add(time_s + kPulse_s, 0);
  };
  using enum MidiRole;
  const auto role = control.control.midi;
  if (role == NoteOn || role == NoteOff) add(0, 0);
  for (int note = 0; note * kEvery_s < duration.value; ++note) {
    const double time_s = note * kEvery_s + kPulse_s;  // key and velocity are there before the note begins
    if (role == Note) add(time_s - kPulse_s, kKeys[note % std::ssize(kKeys)]);
    if (role == Velocity) add(time_s - kPulse_s, kVelocity);
    if (role == NoteOn) pulse(time_s);
    if (role == NoteOff) pulse(time_s + kHeld_s);
  }
  return gesture;
}

/// The same signal on every lane.
Value wire_to(const PortSpec& input) {
  const Value wire{"plant." + input.name, input.at};
  if (input.lanes == 1) return wire;
  return {Value::List(static_cast<std::size_t>(input.lanes), wire), input.at};
}

}  // namespace

std::string describe(const BenchInputs& inputs, const GraphSpec& instrument, bool by_hand) {
  std::map<Receives, std::vector<std::string>> names;
  for (std::size_t n = 0; n < instrument.inputs.size(); ++n) {
    const auto& input = instrument.inputs[n];
    const auto receives = received_by(input, static_cast<int>(n), inputs);
    names[receives].push_back(
        receives == Receives::Motion ? fmt::format("{} (±{})", input.name, amplitude_of(input)) : input.name);
  }
  const char* strikes = inputs.kind == Kind::Keyboard ? "a strike for each press of the space key"
                        : by_hand ? "2 strikes per second, and one for each press of the space key"
                                  : "2 strikes per second";
  const std::map<Receives, std::string> texts = {
      {Receives::Strikes, strikes},
      {Receives::Motion, fmt::format("a sine of {}", kMotionFrequency)},
      {Receives::File, inputs.file.generic_string()},
      {Receives::Silence, "silence"}};
  std::vector<std::string> lines;
  for (const auto& [receives, receivers] : names)
    lines.push_back(fmt::format("{} at {}", texts.at(receives), fmt::join(receivers, ", ")));
  if (takes_notes(instrument))
    lines.emplace_back(inputs.notes ? "2 notes per second as from a keyboard"
                       : by_hand    ? "the notes of the MIDI keyboards that are connected"
                                    : "no notes");
  return fmt::format("{}", fmt::join(lines, "\n"));
}

LoadedScene scene_around(LoadedGraph instrument, const BenchInputs& inputs, Hertz rate, Seconds duration) {
  if (instrument.spec == nullptr) return {std::nullopt, std::move(instrument.errors)};
  SceneSpec scene;
  const auto& graph = *instrument.spec;
  scene.file = scene.duration_at = graph.file;
  scene.name = graph.name;
  scene.about = graph.about;
  scene.source = graph.source;
  scene.rate = rate;
  scene.duration = scene.whole = duration;
  scene.bench = true;
  const auto folder = inputs.file.parent_path();
  auto plant =
      parse_graph_leniently(plant_text(graph, inputs), (folder / "test bench").generic_string(), folder);
  Value::Table wires;
  for (const auto& input : graph.inputs) wires.push_back({input.name, input.at, wire_to(input)});
  for (const auto& control : graph.controls)
    if (inputs.notes && control.control.midi != MidiRole::None) {
      scene.gestures.push_back(played_notes(control, duration));
      wires.push_back({control.name, control.at, {scene.gestures.back().name, control.at}});
    }
  scene.parts.push_back({"instrument", graph.file, instrument.spec, std::move(wires)});
  scene.parts.push_back({"plant", graph.file, plant.spec, {}});
  add_roles_by_name(scene);
  auto errors = std::move(instrument.errors);
  errors.insert(errors.end(), plant.errors.begin(), plant.errors.end());
  return {std::move(scene), std::move(errors)};
}

}  // namespace tactus
