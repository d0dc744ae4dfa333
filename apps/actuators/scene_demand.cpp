#include "apps/actuators/scene_demand.h"

#include <complex>
#include <numbers>

#include "apps/cli/console.h"
#include "apps/cli/target.h"
#include "apps/play/play_report.h"
#include "engine/graph/file/quantity.h"
#include "engine/nodes/table.h"
#include "engine/study/stability/stability_check.h"

namespace tactus::app {
namespace {

double largest(const RecordedSignal& signal) {
  double value = 0.0;
  for (const double sample : signal.samples) value = std::max(value, std::abs(sample));
  return value;
}

/// Half the range: an actuator can be mounted in the middle of it.
double half_range(const RecordedSignal& signal) {
  const auto [low, high] = std::ranges::minmax(signal.samples);
  return (high - low) / 2;
}

/// Does a wire contain "part." of a part other than the instrument?
bool reads_plant(const SceneSpec& scene, const Value& wire) {
  return wire.text() != nullptr && std::ranges::any_of(scene.parts, [&](const ScenePart& part) {
           return part.name != "instrument" && wire.text()->find(part.name + ".") != std::string::npos;
         });
}

/// Raises `most` to `value` where the signal has this unit.
void raise(std::optional<double>& most, const RecordedSignal& signal, const char* unit, double value) {
  if (to_string(signal.dimension) == unit) most = std::max(most.value_or(0.0), value);
}

std::vector<DriveProfile> profiles_of(const std::vector<LimitSource>& sources) {
  std::vector<DriveProfile> profiles;
  for (const auto& source : sources)
    if (source.kind == LimitSource::Kind::Profile)
      if (auto figures = load_profile(source.file)) profiles.push_back({std::move(*figures), source.limits});
  return profiles;
}

/// Force and travel at the ports and sensors. A port with a constant force counts the work of several, and
/// its position is no travel.
void measure(const PlayedScene& played, Demand& demand) {
  const auto travels = [&](const std::string& name) {
    const auto* position = played.recording.find(name);
    if (position == nullptr) return;
    raise(demand.travel, *position, "m", half_range(*position));
    raise(demand.angle, *position, "rad", half_range(*position));
  };
  for (const auto& port : played.scene.ports) {
    const auto* force = played.recording.find(port.force.name);
    if (force == nullptr || !(half_range(*force) > 0)) continue;
    raise(demand.force, *force, "N", largest(*force));
    raise(demand.torque, *force, "N m", largest(*force));
    travels(port.position.name);
  }
  const auto is_in = [&](const char* unit) {
    return std::ranges::any_of(played.recording.signals, [&](const RecordedSignal& signal) {
      return to_string(signal.dimension) == unit;
    });
  };
  demand.turns = is_in("rad") && !is_in("m");
  const bool at_ports = (demand.force || demand.torque) && (demand.travel || demand.angle);
  const auto* instrument = played.scene.part("instrument");
  if (instrument == nullptr) return;
  for (const auto& [input, at, wire] : instrument->wires) {
    if (!reads_plant(played.scene, wire)) continue;
    demand.senses = true;
    if (!at_ports && wire.text() != nullptr) travels(*wire.text());
  }
}

/// The delay is that of the scene; the analysis alone, as by check --quick.
Stability stability_of(const SceneSpec& scene) {
  const LoadedScene loaded{scene};
  StabilityOptions options;
  options.world.delay = scene.delay;
  return or_exit(check_stability({&loaded, nullptr, &standard_nodes()}, options, true)).stability();
}

}  // namespace

double Drive::force_on_case(const ExcursionLimits& model, double mass, double rate_hz) const {
  Fourier fourier{2 * samples.size()};  // the mass is at rest again before the spectrum repeats the drive
  auto force = fourier.forward(samples);
  for (std::size_t bin = 0; bin < force.size(); ++bin) {
    const double w = angular_frequency(bin, fourier.size()) * rate_hz;
    const double turns = w / (2 * std::numbers::pi * model.resonance.value);
    force[bin] *=
        -mass * w * w * model.metres_at_full_scale / std::complex{1 - turns * turns, turns / model.q};
  }
  return std::abs(std::ranges::max(fourier.inverse(force), {}, [](double f) { return std::abs(f); }));
}

Demand demand_of(const std::string& text) {
  const auto target = resolve_target(text);
  const auto played = play_file(target, {});
  const auto& recording = played.recording;
  Demand demand;
  demand.scene = played.scene.name;
  demand.rate_hz = recording.sample_rate.value;
  for (const auto& name : drive_names(recording)) {
    const auto* signal = recording.find("instrument." + name);
    if (signal == nullptr) continue;
    const auto limits = played.scene.drives.named.find(name);
    demand.drives.push_back({name,
                             signal->samples,
                             {signal->samples, demand.rate_hz},
                             limits == played.scene.drives.named.end() ? std::vector<DriveProfile>{}
                                                                       : profiles_of(limits->second)});
  }
  if (demand.drives.empty())
    exit_with({Errc::BadArgument, text, "it drives no actuator", "name a scene with a drive"}, kNo);
  measure(played, demand);
  for (const auto& part : played.scene.parts)
    if (part.name != "instrument" && part.graph && part.graph->file.file)
      demand.plants.push_back(*part.graph->file.file);
  if (demand.senses && target.scene) demand.stability = stability_of(played.scene);
  return demand;
}

}  // namespace tactus::app
