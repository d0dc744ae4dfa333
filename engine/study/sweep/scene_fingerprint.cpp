#include <string>

#include "engine/study/sweep/scene_variants.h"

namespace tactus {
namespace {

void add(Fingerprint& print, const Value::Table& table);

void add(Fingerprint& print, const Value& value) {
  print.add(std::uint64_t{value.data.index()});
  if (const auto* number = value.number()) print.add(*number);
  if (const auto* flag = value.flag()) print.add(std::uint64_t{*flag});
  if (const auto* text = value.text()) print.add(*text);
  if (const auto* table = value.table()) add(print, *table);
  if (const auto* list = value.list()) {
    print.add(std::uint64_t{list->size()});
    for (const auto& item : *list) add(print, item);
  }
}

void add(Fingerprint& print, const Value::Table& table) {
  print.add(std::uint64_t{table.size()});
  for (const auto& field : table) {
    if (field.key == "about") continue;
    print.add(field.key);
    add(print, field.value);
  }
}

template <class Spec>
void add_entries(Fingerprint& print, const std::vector<Spec>& entries) {
  print.add(std::uint64_t{entries.size()});
  for (const auto& entry : entries) add(print.add(entry.name), entry.fields);
}

void add(Fingerprint& print, const std::vector<NodeSpec>& nodes) {
  print.add(std::uint64_t{nodes.size()});
  for (const auto& node : nodes) {
    add(print.add(node.name).add(node.type).add(node.use), node.fields);
    if (node.value) add(print, *node.value);
  }
}

void add(Fingerprint& print, const GraphSpec& graph) {
  add_entries(print, graph.inputs);
  add_entries(print, graph.controls);
  add_entries(print, graph.outputs);
  add(print, graph.nodes);
  for (const auto& network : graph.networks) {
    add(print.add(network.name), network.fields);
    add(print, network.elements);
  }
  for (const auto& [use, part] : graph.parts) add(print.add(use), *part);
}

void add(Fingerprint& print, const Gesture& gesture) {
  print.add(gesture.name).add(std::uint64_t{static_cast<unsigned>(gesture.curve)});
  for (const auto& point : gesture.points) print.add(point.time_s).add(point.value);
}

void add(Fingerprint& print, const DriveLimits& limits) {
  print.add(limits.ceiling).add(limits.slew_per_second).add(limits.dc.level).add(limits.dc.time.value);
  if (const auto& heat = limits.heat)
    for (const double number : {heat->watts_at_full_scale, heat->watts_for_ever, heat->coil_time.value,
                                heat->body_time.value, heat->coil_share})
      print.add(number);
  if (const auto& excursion = limits.excursion)
    for (const double number :
         {excursion->metres, excursion->metres_at_full_scale, excursion->resonance.value, excursion->q})
      print.add(number);
}

void add(Fingerprint& print, const Playability& playability) {
  print.add(std::uint64_t{static_cast<unsigned>(playability.kind)})
      .add(playability.from_s)
      .add(playability.fewest);
  print.add(playability.to_s.value_or(-1));
  for (const auto* signal : {&playability.hits, &playability.contact, &playability.sound, &playability.pitch})
    print.add(signal->name);
  for (const double number : {playability.pitch_hz, playability.begin_s, playability.quiet})
    print.add(number);
}

}  // namespace

Fingerprint& add(Fingerprint& print, const SceneSpec& scene) {
  print.add(scene.rate.value).add(scene.delay.value).add(scene.duration.value).add(scene.seed.value_or(0));
  for (const auto& part : scene.parts) {
    add(print.add(part.name), part.wires);
    if (part.graph != nullptr) add(print, *part.graph);
  }
  for (const auto& gesture : scene.gestures) add(print, gesture);
  print.add(std::uint64_t{scene.converters.on}).add(std::uint64_t(scene.converters.bits));
  add(print, scene.drives.others);
  for (const auto& [name, limits] : scene.drives.named) add(print.add(name), limits);
  if (scene.playability) add(print, *scene.playability);
  return print;
}

}  // namespace tactus
