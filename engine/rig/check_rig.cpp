#include "engine/rig/check_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"
#include "engine/core/named.h"
#include "engine/core/port_name.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

void report_lanes(const RigPort& port, int lanes, ErrorList& errors) {
  std::string example;
  for (int lane = 1; lane <= std::min(lanes, 3); ++lane) example += fmt::format("{}, ", lane);
  errors.add(Errc::OutOfRange, port.at,
             fmt::format("'{}' has {} lane{}, but {} channel{}", port.name, lanes, lanes == 1 ? "" : "s",
                         port.channels.size(), port.channels.size() == 1 ? "" : "s"),
             lanes == 1 ? "give one channel, as in channel = 1"
                        : fmt::format("give one channel per lane, as in channel = [{}{}]",
                                      lanes > 3 ? example : example.substr(0, example.size() - 2),
                                      lanes > 3 ? "…" : ""));
}

class RigCheck {
 public:
  RigCheck(const Rig& rig, const GraphSpec& instrument)
      : rig_(rig), instrument_(instrument), errors_(rig.file) {}

  std::vector<Error> run() {
    check_names(rig_.inputs, instrument_.inputs, "input");
    check_names(rig_.outputs, instrument_.outputs, "output");
    check_names(rig_.controls, instrument_.controls, "control");
    check_complete(instrument_.inputs, rig_.inputs, "input");
    check_complete(instrument_.outputs, rig_.outputs, "output");
    for (const auto& input : instrument_.inputs) check_input(input);
    for (const auto& output : instrument_.outputs)
      output.use == OutputUse::Audio ? check_audio(output.name) : check_drive(output.name);
    for (const auto& control : rig_.controls) check_control(control);
    for (const auto& midi : rig_.midi) check_mover(midi, "a MIDI control needs");
    for (const auto& osc : rig_.osc) check_mover(osc, "an OSC address needs");
    for (const auto& hid : rig_.hid) check_mover(hid, "an axis or a button needs");
    return errors_.take();
  }

 private:
  void report_unknown(const std::string& what, const std::string& name, const Source& at,
                      const std::vector<std::string>& names) {
    if (instrument_.incomplete) return;
    errors_.add(Errc::UnknownName, at, "the instrument has no " + what + " '" + name + "'",
                suggest(name, names, names.empty() ? "it has none" : "it has " + listed(names)));
  }

  template <class Items, class Known>
  void check_names(const Items& items, const Known& known, const char* what) {
    for (const auto& item : items)
      if (find_named(known, item.name) == nullptr) report_unknown(what, item.name, item.at, names_of(known));
  }

  template <class Ports>
  void check_complete(const std::vector<PortSpec>& needed, const Ports& ports, const std::string& what) {
    if (rig_.incomplete) return;
    for (const auto& port : needed)
      if (find_named(ports, port.name) == nullptr)
        errors_.add(Errc::Missing, {rig_.file.file, 1, 1},
                    what + " '" + port.name + "' of the instrument has no channel",
                    "under [" + what + "s], write " + port.name +
                        " = { channel = 1 }, or { channel = \"none\" } to leave it unconnected");
  }

  void check_input(const PortSpec& port) {
    const auto* input = find_named(rig_.inputs, port.name);
    if (input == nullptr || input->channels.empty()) return;
    if (index(port.lanes) != input->channels.size()) report_lanes(*input, port.lanes, errors_);
    const auto volt = parse_unit("V")->dimension, wanted = volt / port.dimension;
    const auto per = to_string(volt / wanted);
    const auto unit = per.empty() ? "V" : volts_per(wanted);
    const auto example =
        per.empty() ? "\"50 mV\"" : "the voltage for 1 " + per + ", such as \"2 " + unit + "\"";
    if (!input->sensitivity && !(wanted == volt))
      errors_.add(Errc::Missing, input->at,
                  "'" + port.name + "' is in " + per + ", but its voltage is not given",
                  "give volts_per_full_scale, and as sensitivity " + example);
    if (!input->sensitivity || input->sensitivity->bare) return;
    if (!(input->sensitivity->unit.dimension == wanted))
      errors_.add(Errc::UnitMismatch, input->sensitivity_at,
                  "the sensitivity of '" + port.name + "' must be in " + unit, "give " + example);
  }

  void check_audio(const std::string& name) {
    const auto* output = find_named(rig_.outputs, name);
    for (const int channel : output != nullptr ? output->channels : std::vector<int>{})
      if (const auto* actuator = rig_.actuator_on(channel)) {
        const auto& profile = actuator->drive.profile;
        return errors_.add(Errc::BadArgument, output->at,
                           fmt::format("'{}' is an audio output, but {} drives an actuator{}", name,
                                       channel_name(channel), profile.empty() ? "" : " (" + profile + ")"),
                           "audio outputs have weaker limits than drives; use another channel, or make this "
                           "output a drive in the instrument");
      }
  }

  void check_drive(const std::string& name) {
    const auto* output = find_named(rig_.outputs, name);
    const auto has_profile = [this](int channel) {
      const auto* actuator = rig_.actuator_on(channel);
      return actuator != nullptr && actuator->has_actuator();
    };
    if (output != nullptr && std::ranges::none_of(output->channels, has_profile))
      check_ceiling(output->drive, errors_);
  }

  void check_control(const Rig::Control& set) {
    const auto* entry = find_named(instrument_.controls, set.name);
    if (entry == nullptr || !entry->unit_known) return;
    const auto& control = entry->control;
    if (!set.value.bare && !(set.value.unit.dimension == control.unit.dimension))
      errors_.add(Errc::UnitMismatch, set.at,
                  "'" + set.name + "' is set in " + named(set.value.unit.dimension) + ", but it is in " +
                      named(control.unit.dimension),
                  "give for instance " + in_unit(control.value, control.unit));
    else if (!control.range.contains(set.value.si))
      errors_.add(Errc::OutOfRange, set.at,
                  "'" + set.name + "' cannot be " + in_unit(set.value.si, control.unit),
                  "it runs from " + in_unit(control.range.low, control.unit) + " to " +
                      in_unit(control.range.high, control.unit));
  }

  /// A control is moved over its range.
  template <class Mover>
  void check_mover(const Mover& mover, const char* needed) {
    const auto* entry = find_named(instrument_.controls, mover.control);
    if (entry == nullptr)
      return report_unknown("control", mover.control, mover.at, names_of(instrument_.controls));
    if (find(entry->fields, "range") == nullptr)
      errors_.add(Errc::Missing, mover.at, fmt::format("'{}' has no range, which {}", mover.control, needed),
                  "give it a range in the instrument, as in range = [0, 1]");
  }

  static std::string named(const Dimension& dimension) {
    return dimension.plain() ? "plain numbers" : to_string(dimension);
  }

  const Rig& rig_;
  const GraphSpec& instrument_;
  ErrorList errors_;
};

bool left_out(const RigPort& port) { return port.channels.empty(); }

/// 0 in the unit of a port, in each of its lanes, under its name.
NodeSpec resting(const PortSpec& input) {
  const auto unit = to_string(input.dimension);
  const Value zero{unit.empty() ? std::string{"0"} : "0 " + unit, input.at};
  NodeSpec node;
  node.name = input.name;
  node.at = node.type_at = input.at;
  node.value = input.lanes == 1 ? zero : Value{Value::List(index(input.lanes), zero), input.at};
  return node;
}

}  // namespace

std::vector<Error> check_rig(const Rig& rig, const GraphSpec& instrument) {
  return RigCheck{rig, instrument}.run();
}

std::shared_ptr<const GraphSpec> without_left_out(const Rig& rig,
                                                  std::shared_ptr<const GraphSpec> instrument) {
  const auto none = [](const auto& ports) { return std::none_of(ports.begin(), ports.end(), left_out); };
  if (instrument == nullptr || (none(rig.inputs) && none(rig.outputs))) return instrument;
  auto played = std::make_shared<GraphSpec>(*instrument);
  const auto leave_out = [](const auto& ports) {
    return [&ports](const EntrySpec& entry) {
      const auto* port = find_named(ports, entry.name);
      return port != nullptr && left_out(*port);
    };
  };
  std::erase_if(played->outputs, leave_out(rig.outputs));
  const auto rests = leave_out(rig.inputs);
  for (const auto& input : played->inputs)
    if (rests(input)) played->nodes.push_back(resting(input));
  std::erase_if(played->inputs, rests);
  return played;
}

Checked<RigWiring> wire_rig(const Rig& rig, const Plan& schedule) {
  RigWiring wiring;
  ErrorList errors{rig.file};
  std::map<std::string, int> lanes;  // of each port
  /// The channel of the card, from 0 on, of the next lane; 0 if the port has no more channels.
  const auto next = [&](const RigPort& port) {
    const auto lane = index(lanes[port.name]++);
    return lane < port.channels.size() ? port.channels[lane] - 1 : 0;
  };
  const auto check = [&](const RigPort& port) {
    if (lanes.contains(port.name) && index(lanes[port.name]) != port.channels.size())
      report_lanes(port, lanes[port.name], errors);
  };
  for (const auto& name : schedule.input_names) {
    const auto* input = find_named(rig.inputs, port_of(name));
    if (input == nullptr) continue;
    wiring.in_map.push_back(next(*input));
    wiring.input_scales.push_back(input->scale());
  }
  for (const auto& channel : schedule.channels) {
    const auto* output = find_named(rig.outputs, port_of(channel.name));
    if (channel.use == OutputUse::Tap || output == nullptr) continue;
    wiring.out_map.push_back(next(*output));
    wiring.limits.named[channel.name] = rig.limit_sources(wiring.out_map.back() + 1);
  }
  for (const auto& input : rig.inputs) check(input);
  for (const auto& output : rig.outputs) check(output);
  if (errors.any()) return tl::unexpected(errors.take());
  return wiring;
}

Result<int> padding_frames(std::optional<Seconds> measured, Seconds target, Hertz sample_rate,
                           const std::string& where) {
  if (!measured)
    return fail(
        Errc::Missing, where, "the delay of this device has not been measured, so it cannot be extended",
        "measure it with tactus latency measure, or write it into the rig: [delay] measured = \"12.4 ms\"");
  const double frames = frames_in(target - *measured, sample_rate);
  if (frames < -0.5)
    return fail(Errc::OutOfRange, where,
                "the delay of the device itself is " +
                    short_quantity(measured->value, parse_unit("s")->dimension) + ", longer than " +
                    short_quantity(target.value, parse_unit("s")->dimension),
                "request a longer delay, or use smaller blocks");
  return static_cast<int>(std::lround(std::max(frames, 0.0)));
}

}  // namespace tactus
