#include "apps/actuators/scene_demand.h"

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

/// Force and travel at the ports and sensors. A port with a constant force counts the work of several, and
/// its position is no travel.
void measure(const PlayedScene& played, Demand& demand) {
  const auto newton = parse_unit("N")->dimension, metre = parse_unit("m")->dimension;
  const auto signal = [&](const std::string& name, const Dimension& dimension) {
    const auto* found = played.recording.find(name);
    return found != nullptr && found->dimension == dimension ? found : nullptr;
  };
  const auto travels = [&](const RecordedSignal* position) {
    if (position != nullptr) demand.travel = std::max(demand.travel.value_or(0.0), half_range(*position));
  };
  for (const auto& port : played.scene.ports) {
    const auto* force = signal(port.force.name, newton);
    if (force == nullptr || !(half_range(*force) > 0)) continue;
    demand.force = std::max(demand.force.value_or(0.0), largest(*force));
    travels(signal(port.position.name, metre));
  }
  const auto* instrument = played.scene.part("instrument");
  if (instrument == nullptr) return;
  for (const auto& [input, at, wire] : instrument->wires) {
    if (!reads_plant(played.scene, wire)) continue;
    demand.senses = true;
    if (demand.force && demand.travel) continue;
    travels(signal(wire.text() != nullptr ? *wire.text() : "", metre));
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
    demand.drives.push_back(
        {name,
         signal->samples,
         {signal->samples, demand.rate_hz},
         limits == played.scene.drives.named.end() ? std::vector<LimitSource>{} : limits->second});
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
