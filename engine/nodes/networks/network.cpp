#include "engine/nodes/networks/network.h"

#include <fmt/format.h>

#include <utility>

#include "engine/core/dimension.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/networks/network_node.h"

namespace tactus {
namespace {

/// "N/m^1.5" from the exponent in the file; not checked where that is an expression.
std::string contact_unit(const NodeSpec& element, double fallback) {
  double exponent = fallback;
  if (const auto* value = find(element.fields, "exponent")) {
    const auto parsed = value->text() ? parse_quantity(*value->text()) : std::nullopt;
    if (value->number())
      exponent = *value->number();
    else if (parsed && parsed->unit.dimension.plain())
      exponent = parsed->si;
    else
      return "any";
  }
  return exponent == 1.0 ? "N/m" : fmt::format("N/m^{}", exponent);
}

std::string unit_of(const ElementField& field, const ElementType& type, const NodeSpec& element) {
  if (field.unit != "N/m^exponent") return field.unit;
  for (const auto& other : type.fields)
    if (other.name == "exponent") return contact_unit(element, *other.fallback);
  return "any";
}

void declare_inputs(NodeType& type, const NodeSpec& spec, NetworkElement& element) {
  for (const auto& field : element.type->fields) {
    const bool absent = (field.optional && find(spec.fields, field.name) == nullptr) ||
                        (element.pressed_by >= 0 && field.name == element.type->force_field);
    element.ports.push_back(absent ? -1 : static_cast<int>(type.inputs.size()));
    if (absent) continue;
    type.inputs.push_back({.name = element.name + "." + field.name,
                           .unit = unit_of(field, *element.type, spec),
                           .doc = field.doc,
                           .fallback = field.fallback,
                           .low = field.low,
                           .high = field.high,
                           .late = field.signal,
                           .fixed = !field.signal});
  }
}

void declare_outputs(NodeType& type, const NetworkElement& element) {
  const bool two_sided = element.type->two_sided && element.type->two_sided(element);
  const auto declare = [&](std::string name, const ElementQuantity& quantity) {
    type.outputs.push_back({.name = std::move(name),
                            .unit = quantity.unit,
                            .doc = quantity.doc,
                            .range = two_sided ? Interval{} : quantity.range});
  };
  const auto& quantities = element.type->quantities;
  for (const auto& quantity : quantities) declare(element.name + "." + quantity.name, quantity);
  if (!quantities.empty()) declare(element.name, quantities.front());
}

std::uint64_t fingerprint_of(const NetworkLayout& layout) {
  Fingerprint print;
  print.add(static_cast<std::uint64_t>(layout.solver)).add(static_cast<std::uint64_t>(layout.oversample));
  for (const auto& element : layout.elements) {
    print.add(element.name).add(element.type->name);
    for (const int end : element.ends) print.add(static_cast<std::uint64_t>(end));
    for (const int within : element.within) print.add(static_cast<std::uint64_t>(within));
    for (const int port : element.ports) print.add(static_cast<std::uint64_t>(port));
    for (const auto& setting : element.settings)
      print.add(setting.text).add(static_cast<std::uint64_t>(setting.number));
    print.add(static_cast<std::uint64_t>(element.pressed_by));
  }
  return print.value();
}

std::string source_of(Solver solver) {
  switch (solver) {
    case Solver::Explicit:
      return "Cadoz, Luciani & Florens, Computer Music Journal 17(1), 1993";
    case Solver::Implicit:
      return "Newmark, J. Eng. Mech. 85, 1959; Bilbao, Torin & Chatziioannou, Acta Acustica 101, 2015";
    case Solver::Exact:
      return "Van Loan, IEEE Trans. Autom. Control 23, 1978";
    case Solver::Reference:
      return "Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, Springer, 1993";
    case Solver::Passive:
    case Solver::Auto:
      break;
  }
  return "Ducceschi, Bilbao, Willemsen & Serafin, JASA 149, 2021";
}

}  // namespace

Checked<std::shared_ptr<const NodeType>> network_type(const NetworkSpec& spec) {
  auto layout = read_network_layout(spec);
  if (!layout) return tl::unexpected(layout.error());
  auto type = std::make_shared<NodeType>();
  type->name = "network";
  type->group = "networks";
  type->summary = "Masses on a line, joined by springs, contacts, frictions and coils.";
  type->source = source_of(layout->solver);
  type->skips_unread = true;
  for (std::size_t i = 0; i < spec.elements.size(); ++i) {
    declare_inputs(*type, spec.elements[i], layout->elements[i]);
    declare_outputs(*type, layout->elements[i]);
  }
  type->outputs.push_back({.name = "energy", .unit = "J", .doc = "stored in the whole network", .range = {}});
  type->fingerprint = fingerprint_of(*layout);
  type->make = [layout = std::move(*layout)](const NodeSetup& setup) {
    return make_network_node(layout, setup);
  };
  return type;
}

}  // namespace tactus
