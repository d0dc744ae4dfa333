#include "engine/nodes/world/world.h"

#include <utility>

#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/world/world_node.h"

namespace tactus {
#if defined(TACTUS_HAS_ODE)

namespace {

void declare_inputs(NodeType& type, const NodeSpec& spec, WorldElement& element) {
  for (const auto& field : element.type->fields) {
    const bool absent = field.optional && find(spec.fields, field.name) == nullptr;
    element.ports.push_back(absent ? -1 : static_cast<int>(type.inputs.size()));
    if (absent) continue;
    auto& input = type.inputs.emplace_back(field);
    input.name = element.name + "." + field.name;
  }
}

OutputPort output_port(std::string name, const WorldQuantity& quantity) {
  const bool trigger = quantity.reading == WorldReading::Trigger;
  return {.name = std::move(name),
          .unit = quantity.unit,
          .doc = quantity.doc,
          .kind = trigger ? OutputKind::Trigger : OutputKind::Signal,
          .event_level = quantity.event_level,
          .range = trigger ? Interval{0, 1} : Interval{}};
}

void declare_outputs(NodeType& type, WorldElement& element) {
  element.first_output = static_cast<int>(type.outputs.size());
  const auto& quantities = element.type->quantities;
  for (const auto& quantity : quantities)
    type.outputs.push_back(output_port(element.name + "." + quantity.name, quantity));
  if (!quantities.empty()) type.outputs.push_back(output_port(element.name, quantities.front()));
}

std::uint64_t fingerprint_of(const WorldLayout& layout) {
  Fingerprint print;
  print.add(std::string_view{"world"}).add(std::uint64_t{layout.direct});
  for (const auto& element : layout.elements) {
    print.add(element.name).add(element.type->name);
    for (const int end : element.ends) print.add(static_cast<std::uint64_t>(end));
    for (const int port : element.ports) print.add(static_cast<std::uint64_t>(port));
    for (const auto& setting : element.settings) {
      print.add(setting.text);
      for (const double number : setting.numbers) print.add(number);
    }
  }
  return print.value();
}

Result<std::unique_ptr<Node>> make_world_node(const WorldLayout& layout, const NodeSetup& setup) {
  auto recipe = build_world(layout, setup);
  if (const auto fits = setup.take_memory(recipe.model.bytes() / sizeof(double)); !fits)
    return tl::unexpected(fits.error());
  setup.variant = recipe.variant;
  auto bodies = RigidBodies::make(recipe.model);
  if (!bodies) return tl::unexpected(bodies.error());
  return std::make_unique<WorldNode>(std::move(recipe), setup, std::move(*bodies));
}

}  // namespace

#endif

Checked<std::shared_ptr<const NodeType>> world_type(const NetworkSpec& spec) {
  auto layout = read_world_layout(spec);
  if (!layout) return tl::unexpected(layout.error());
#if defined(TACTUS_HAS_ODE)
  auto type = std::make_shared<NodeType>();
  type->name = "world";
  type->group = "worlds";
  type->summary = "Rigid bodies in space, with contacts, joints and haptic handles.";
  type->source = "Stewart & Trinkle, Int. J. Numer. Methods Eng. 39, 1996; Open Dynamics Engine 0.16";
  type->skips_unused_outputs = true;
  for (std::size_t i = 0; i < spec.elements.size(); ++i) {
    declare_inputs(*type, spec.elements[i], layout->elements[i]);
    declare_outputs(*type, layout->elements[i]);
  }
  for (const auto& quantity : world_quantities())
    type->outputs.push_back(output_port(quantity.name, quantity));
  type->fingerprint = fingerprint_of(*layout);
  const auto shared = std::make_shared<const WorldLayout>(std::move(*layout));
  type->make = [shared](const NodeSetup& setup) { return make_world_node(*shared, setup); };
  type->needed_inputs = [shared](const NodeSetup& setup) { return build_world(*shared, setup).needed; };
  return type;
#else
  return tl::unexpected(
      std::vector<Error>{{Errc::Missing, spec.at.text(),
                          "this build has no rigid bodies, so world '" + spec.name + "' cannot run",
                          "run scripts/setup libode-dev and build again"}});
#endif
}

}  // namespace tactus
