#include <concepts>
#include <optional>
#include <string>

#include "engine/study/sweep/scene_variants.h"

namespace tactus {
namespace {

/// Adds what scenes are made of.
struct SceneHash {
  Fingerprint& print;

  template <class... Parts>
  void operator()(const Parts&... parts) {
    (add(parts), ...);
  }

 private:
  void add(double number) { print.add(number); }
  void add(const std::string& text) { print.add(text); }
  template <class Number>
  requires std::integral<Number> || std::is_enum_v<Number>
  void add(Number number) { print.add(static_cast<std::uint64_t>(number)); }
  template <class Item>
  void add(const std::vector<Item>& items) {
    add(items.size());
    for (const auto& item : items) add(item);
  }
  template <class Key, class Item>
  void add(const std::map<Key, Item>& items) {
    for (const auto& [key, item] : items) (*this)(key, item);
  }
  template <class Part>
  void add(const std::optional<Part>& part) {
    add(part.has_value());
    if (part) add(*part);
  }

  void add(const Value& value) {
    add(value.data.index());
    std::visit(*this, value.data);
  }
  void add(const Field& field) {
    if (field.key != "about") (*this)(field.key, field.value);
  }
  void add(const EntrySpec& entry) { (*this)(entry.name, entry.fields); }
  void add(const NodeSpec& node) { (*this)(node.name, node.type, node.use, node.fields, node.value); }
  void add(const NetworkSpec& network) { (*this)(network.name, network.fields, network.elements); }
  void add(const std::shared_ptr<const GraphSpec>& graph) {
    if (graph != nullptr)
      (*this)(graph->inputs, graph->controls, graph->outputs, graph->nodes, graph->networks, graph->parts);
  }
  void add(const ScenePart& part) { (*this)(part.name, part.wires, part.graph); }
  void add(const Gesture::Point& point) { (*this)(point.time_s, point.value); }
  void add(const Gesture& gesture) { (*this)(gesture.name, gesture.curve, gesture.points); }
  void add(const HeatLimits& heat) {
    (*this)(heat.watts_at_full_scale, heat.watts_for_ever, heat.coil_time.value, heat.body_time.value,
            heat.coil_share);
  }
  void add(const ExcursionLimits& excursion) {
    (*this)(excursion.metres, excursion.metres_at_full_scale, excursion.resonance.value, excursion.q);
  }
  void add(const DriveLimits& limits) {
    (*this)(limits.ceiling, limits.slew_per_second, limits.dc.level, limits.dc.time.value, limits.heat,
            limits.excursion);
  }
  void add(const LimitSource& source) { (*this)(static_cast<std::uint64_t>(source.kind), source.limits); }
  void add(const LimitRaise& raise) { (*this)(raise.output, raise.limit, raise.value); }
  void add(const Playability& rules) {
    (*this)(rules.kind, rules.from_s, rules.to_s, rules.fewest, rules.roll, rules.rate_hz, rules.hits.name,
            rules.contact.name, rules.sound.name, rules.pitch.name, rules.pitch_hz, rules.begin_s,
            rules.quiet);
  }
};

}  // namespace

Fingerprint& add(Fingerprint& print, const SceneSpec& scene) {
  SceneHash{print}(scene.rate.value, scene.delay.value, scene.duration.value, scene.seed, scene.parts,
                   scene.gestures, scene.converters.on, scene.converters.bits, scene.drives.named,
                   scene.drives.drives, scene.drives.raises, scene.playability);
  return print;
}

}  // namespace tactus
