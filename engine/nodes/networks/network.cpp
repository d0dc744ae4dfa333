#include "engine/nodes/networks/network.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engine/core/dimension.h"
#include "engine/core/index.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/networks/network_builder.h"
#include "engine/nodes/networks/solver_names.h"
#include "engine/nodes/process.h"

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
    const bool absent = !element.has(field) || (field.optional && find(spec.fields, field.name) == nullptr) ||
                        (element.pressed_by >= 0 && field.name == element.type->force_field);
    element.ports.push_back(absent ? -1 : static_cast<int>(type.inputs.size()));
    if (absent) continue;
    auto& input = type.inputs.emplace_back(field);
    input.name = element.name + "." + field.name;
    input.unit = unit_of(field, *element.type, spec);
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
  for (const auto& quantity : quantities)
    if (element.has(quantity)) declare(element.name + "." + quantity.name, quantity);
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

class NetworkNode final : public Node, public NetworkView {
 public:
  NetworkNode(NetworkView view, const NodeType& type, const NetworkBuilder& builder)
      : NetworkView(std::move(view)),
        fingerprint_(type.fingerprint),
        origins_(network.origins(builder.original_parts, builder.original_signals)),
        left_out_(builder.left_out()),
        now_(recipe.signal_ports.size()),
        read_(readings.size()) {
    for (const auto& input : type.inputs) late_.push_back(input.late);
  }

  void process(const NodeBlock& block) noexcept override {
    const std::size_t count = find_read(block, read_);
    for (int frame = 0; frame < block.frames; ++frame) {
      write(block, frame, count);
      step(block, frame);
    }
  }
  void emit(const NodeBlock& block) noexcept override { write(block, 0, find_read(block, read_)); }
  void absorb(const NodeBlock& block) noexcept override { step(block, 0); }
  void reset() noexcept override { network.reset(state); }
  void copy(const Node& other) noexcept override {
    if (const auto* same = dynamic_cast<const NetworkNode*>(&other)) state = same->state;
  }

  void adopt(const Node& before) noexcept override {
    const auto* other = dynamic_cast<const NetworkNode*>(&before);
    if (other != nullptr && other->fingerprint_ == fingerprint_)
      network.adopt(state, origins_, {other->network, other->state, other->origins_});
  }

  std::string about() const override {
    const auto choice = explain_choice(network.choice());
    return choice.empty() ? choice : "solver " + choice;
  }

  std::vector<LeftOut> left_out() const override { return left_out_; }

  DelayRange delay(int input, int) const override {
    return late_[index(input)] ? DelayRange{1, 1} : DelayRange{};
  }

 private:
  void write(const NodeBlock& block, int frame, std::size_t count) const noexcept {
    for (std::size_t i = 0; i < count; ++i)
      block.out[read_[i]][frame] = readings[read_[i]].value(network, state);
  }

  void step(const NodeBlock& block, int frame) noexcept {
    for (std::size_t i = 0; i < now_.size(); ++i) now_[i] = block.in[recipe.signal_ports[i]][frame];
    network.step(state, now_.data());
  }

  std::uint64_t fingerprint_;  ///< which elements, joined how
  StateOrigins origins_;
  std::vector<LeftOut> left_out_;
  std::vector<double> now_;
  std::vector<std::size_t> read_;
  std::vector<bool> late_;
};

/// The running node of a network.
Result<std::unique_ptr<Node>> make_network_node(const NetworkLayout& layout, const NodeSetup& setup) {
  std::size_t points = 0;
  for (const auto& element : layout.elements) points += index(element.points());
  // A point, its springs and what a solver keeps for them, 2 kB; before they are made.
  if (const auto fits = setup.take_memory(250 * points); !fits) return tl::unexpected(fits.error());
  NetworkBuilder builder(layout, setup);
  auto couplings = builder.elements.contacts.size() + builder.elements.frictions.size();
  for (const auto& bond : builder.elements.bonds) couplings += index(bond.axes);
  const auto each =
      layout.solver == Solver::Explicit ? builder.elements.frictions.size() : points + 2 * couplings;
  if (const auto fits = setup.take_memory(couplings * each); !fits) return tl::unexpected(fits.error());
  setup.variant = builder.variant();
  NetworkRecipe recipe;
  recipe.signals = static_cast<int>(builder.signal_ports.size());
  recipe.rate = setup.sample_rate;
  recipe.signal_ports = builder.signal_ports;
  builder.name_parts(recipe);
  recipe.elements = std::move(builder.elements);
  auto network =
      Network::make(recipe.elements, recipe.signals, recipe.rate, layout.solver, layout.oversample);
  if (!network) return tl::unexpected(network.error());
  recipe.solver = network->solver();
  recipe.oversample = network->oversample();
  return std::make_unique<NetworkNode>(
      NetworkView{std::move(recipe), std::move(*network), builder.readings()}, *setup.type, builder);
}

/// Signals of elements that matter to what is read, and everything that is fixed.
std::vector<bool> needed_inputs(const NetworkLayout& layout, NodeSetup setup) {
  const auto& ports = setup.type->inputs;
  std::vector<bool> needed;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    needed.push_back(ports[i].fixed);
    // A number that controls decide: as long as it is not known, it may be anything but 0.
    if (ports[i].fixed && !setup.inputs[i].constant)
      setup.inputs[i].constant = std::clamp(1.0, ports[i].low, ports[i].high);
  }
  for (const int port : NetworkBuilder{layout, setup}.signal_ports) needed[index(port)] = true;
  return needed;
}

}  // namespace

Checked<std::shared_ptr<const NodeType>> network_type(const NetworkSpec& spec) {
  auto layout = read_network_layout(spec);
  if (!layout) return tl::unexpected(layout.error());
  auto type = std::make_shared<NodeType>();
  type->name = "network";
  type->group = "networks";
  type->summary =
      "Masses that move on a line or in space, connected by springs, contacts, friction and coils.";
  type->source = source_of(layout->solver);
  type->skips_unused_outputs = true;
  type->turns = layout->turns;
  for (std::size_t i = 0; i < spec.elements.size(); ++i) {
    declare_inputs(*type, spec.elements[i], layout->elements[i]);
    declare_outputs(*type, layout->elements[i]);
  }
  type->outputs.push_back(
      {.name = "energy", .unit = "J", .doc = "energy stored in the whole network", .range = {}});
  type->fingerprint = fingerprint_of(*layout);
  const auto shared = std::make_shared<const NetworkLayout>(std::move(*layout));
  type->make = [shared](const NodeSetup& setup) { return make_network_node(*shared, setup); };
  type->needed_inputs = [shared](const NodeSetup& setup) { return needed_inputs(*shared, setup); };
  return type;
}

}  // namespace tactus
