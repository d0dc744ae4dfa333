#include "engine/nodes/network_node.h"

#include <algorithm>
#include <utility>

namespace tactus {
namespace {

/// One output: what to ask which part of the network for.
struct Reading {
  ElementQuantity::Kind kind;
  int part;
  int push = -1;  // of a hand: the applied force that adds to its spring
};

/// Which parts of the physical network an element has become.
struct Parts {
  int point = -1, spring = -1, contact = -1, force = -1, coil = -1;
};

class NetworkBuilder {
 public:
  NetworkBuilder(const NetworkLayout& layout, const NodeSetup& setup) : layout_(layout), setup_(setup) {
    parts_.resize(layout.elements.size());
    // Points first: links name them by their index, and may stand before them in the file.
    for (const bool points : {true, false})
      for (std::size_t i = 0; i < layout.elements.size(); ++i)
        if ((layout.elements[i].type->ends == ElementType::Ends::None) == points)
          add(layout.elements[i], parts_[i]);
  }

  std::vector<Reading> readings() const {
    std::vector<Reading> readings;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const auto& quantities = layout_.elements[i].type->quantities;
      for (const auto& quantity : quantities) readings.push_back(reading(quantity.kind, parts_[i]));
      if (!quantities.empty()) readings.push_back(reading(quantities.front().kind, parts_[i]));
    }
    readings.push_back({ElementQuantity::Kind::Energy, 0});
    return readings;
  }

  /// What the elements are called, by what they have become.
  void name_parts(NetworkRecipe& recipe) const {
    recipe.points.resize(elements.points.size());
    recipe.springs.resize(elements.springs.size());
    recipe.contacts.resize(elements.contacts.size());
    const auto name = [](std::vector<std::string>& names, int part, const std::string& element) {
      if (part >= 0) names[static_cast<std::size_t>(part)] = element;
    };
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const auto& element = layout_.elements[i].name;
      name(recipe.points, parts_[i].point, element);
      name(recipe.springs, parts_[i].spring, element);
      name(recipe.contacts, parts_[i].contact, element);
    }
  }

  NetworkElements elements;
  std::vector<int> signal_ports;  // input of each signal of the network

 private:
  static Reading reading(ElementQuantity::Kind kind, const Parts& parts) {
    using Kind = ElementQuantity::Kind;
    switch (kind) {
      case Kind::Position:
      case Kind::Velocity:
        return {kind, parts.point};
      case Kind::Extension:
        return {kind, parts.spring};
      case Kind::SpringForce:
        return {kind, parts.spring, parts.force};
      case Kind::Indentation:
      case Kind::ContactForce:
        return {kind, parts.contact};
      case Kind::AppliedForce:
        return {kind, parts.force};
      case Kind::Current:
      case Kind::CoilForce:
        return {kind, parts.coil};
      case Kind::Energy:
        break;
    }
    return {kind, 0};
  }

  int port(const NetworkLayout::Element& element, std::string_view field) const {
    const auto& fields = element.type->fields;
    const auto at =
        std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.name == field; });
    return element.ports[static_cast<std::size_t>(at - fields.begin())];
  }

  double number(const NetworkLayout::Element& element, std::string_view field) const {
    const auto i = static_cast<std::size_t>(port(element, field));
    const auto& port = setup_.type->inputs[i];
    const double value = setup_.inputs[i].constant.value_or(port.fallback.value_or(0.0));
    return std::clamp(value, port.low, port.high);
  }

  int signal(const NetworkLayout::Element& element, std::string_view field) {
    signal_ports.push_back(port(element, field));
    return static_cast<int>(signal_ports.size()) - 1;
  }

  int point_of(int element) const {
    return element < 0 ? -1 : parts_[static_cast<std::size_t>(element)].point;
  }

  template <class List, class Part>
  static int append(List& list, Part part) {
    list.push_back(std::move(part));
    return static_cast<int>(list.size()) - 1;
  }

  void add(const NetworkLayout::Element& e, Parts& parts) {
    const auto& type = e.type->name;
    const int first = point_of(e.ends[0]), second = point_of(e.ends[1]);
    if (type == "mass")
      parts.point =
          append(elements.points,
                 Point{Point::Kind::Mass, number(e, "mass"), number(e, "at"), number(e, "velocity"), {}});
    else if (type == "ground")
      parts.point = append(elements.points, Point{Point::Kind::Ground, 0.0, number(e, "at"), 0.0, {}});
    else if (type == "motion")
      parts.point =
          append(elements.points, Point{Point::Kind::Motion, 0.0, 0.0, 0.0, {signal(e, "position"), {}}});
    else if (type == "spring")
      parts.spring = append(elements.springs, Spring{first, second, number(e, "stiffness"),
                                                     number(e, "damping"), number(e, "rest")});
    else if (type == "damper")
      parts.spring = append(elements.springs, Spring{first, second, 0.0, number(e, "damping"), 0.0});
    else if (type == "contact")
      parts.contact = append(elements.contacts, contact(e, first, second));
    else if (type == "force")
      parts.force = append(elements.forces, AppliedForce{first, {signal(e, "force"), {}}});
    else if (type == "hand")
      add_hand(e, first, parts);
    else
      parts.coil = append(elements.coils, Coil{first,
                                               second,
                                               number(e, "force_factor"),
                                               number(e, "resistance"),
                                               number(e, "inductance"),
                                               {signal(e, "voltage"), {}}});
  }

  Contact contact(const NetworkLayout::Element& e, int lower, int upper) const {
    Contact contact{lower,
                    upper,
                    number(e, "stiffness"),
                    number(e, "exponent"),
                    number(e, "loss"),
                    {},
                    number(e, "offset")};
    if (port(e, "restitution") >= 0) contact.restitution = number(e, "restitution");
    return contact;
  }

  void add_hand(const NetworkLayout::Element& e, int on, Parts& parts) {
    const auto made =
        attach(elements, Hand{on, number(e, "stiffness"), number(e, "damping"), Hertz{number(e, "bandwidth")},
                              signal(e, "position"), signal(e, "force")});
    parts.point = made.point;
    parts.spring = made.spring;
    parts.force = made.force;
  }

  const NetworkLayout& layout_;
  const NodeSetup& setup_;
  std::vector<Parts> parts_;
};

class NetworkNode final : public Node, public NetworkView {
 public:
  NetworkNode(NetworkRecipe recipe, Network network, std::vector<Reading> readings, const NodeType& type)
      : fingerprint_(type.fingerprint),
        recipe_(std::move(recipe)),
        network_(std::move(network)),
        state_(network_.initial_state()),
        readings_(std::move(readings)),
        signal_ports_(recipe_.signal_ports),
        now_(signal_ports_.size()),
        read_(readings_.size()),
        late_(type.inputs.size()) {
    for (const int port : signal_ports_) late_[static_cast<std::size_t>(port)] = true;
  }

  void process(const NodeBlock& block) noexcept override {
    const std::size_t count = find_read(block);
    for (int frame = 0; frame < block.frames; ++frame) {
      write(block, frame, count);
      step(block, frame);
    }
  }
  void emit(const NodeBlock& block) noexcept override { write(block, 0, find_read(block)); }
  void absorb(const NodeBlock& block) noexcept override { step(block, 0); }
  void reset() noexcept override { network_.reset(state_); }

  void adopt(Node& before) noexcept override {
    const auto* other = dynamic_cast<const NetworkNode*>(&before);
    if (other != nullptr && other->fingerprint_ == fingerprint_) network_.adopt(state_, other->state_);
  }

  DelayRange delay(int input, int) const override {
    return late_[static_cast<std::size_t>(input)] ? DelayRange{1, 1} : DelayRange{};
  }

  const NetworkRecipe& recipe() const override { return recipe_; }
  double energy() const override { return network_.energy(state_); }
  double shown(const Network& network, const NetworkState& state, int output) const override {
    return value(readings_[static_cast<std::size_t>(output)], network, state);
  }

 private:
  /// Puts the outputs that somebody reads to the front of `read_`.
  std::size_t find_read(const NodeBlock& block) noexcept {
    std::size_t count = 0;
    for (std::size_t i = 0; i < readings_.size(); ++i)
      if (block.out[i] != nullptr) read_[count++] = i;
    return count;
  }

  void write(const NodeBlock& block, int frame, std::size_t count) const noexcept {
    for (std::size_t i = 0; i < count; ++i)
      block.out[read_[i]][frame] = value(readings_[read_[i]], network_, state_);
  }

  void step(const NodeBlock& block, int frame) noexcept {
    for (std::size_t i = 0; i < now_.size(); ++i) now_[i] = block.in[signal_ports_[i]][frame];
    network_.step(state_, now_.data());
  }

  static double value(const Reading& reading, const Network& network, const NetworkState& state) noexcept {
    using Kind = ElementQuantity::Kind;
    switch (reading.kind) {
      case Kind::Position:
        return network.position(state, reading.part);
      case Kind::Velocity:
        return network.velocity(state, reading.part);
      case Kind::Extension:
        return network.extension(state, reading.part);
      case Kind::SpringForce:
        return network.spring_force(state, reading.part) +
               (reading.push < 0 ? 0.0 : network.applied_force(state, reading.push));
      case Kind::Indentation:
        return network.indentation(state, reading.part);
      case Kind::ContactForce:
        return network.contact_force(state, reading.part);
      case Kind::AppliedForce:
        return network.applied_force(state, reading.part);
      case Kind::Current:
        return network.current(state, reading.part);
      case Kind::CoilForce:
        return network.coil_force(state, reading.part);
      case Kind::Energy:
        break;
    }
    return network.energy(state);
  }

  std::uint64_t fingerprint_;  ///< which elements, joined how
  NetworkRecipe recipe_;
  Network network_;
  NetworkState state_;
  std::vector<Reading> readings_;
  std::vector<int> signal_ports_;
  std::vector<double> now_;
  std::vector<std::size_t> read_;
  std::vector<bool> late_;
};

}  // namespace

Result<std::unique_ptr<Node>> make_network_node(const NetworkLayout& layout, const NodeSetup& setup) {
  NetworkBuilder builder(layout, setup);
  const auto masses = builder.elements.points.size(), contacts = builder.elements.contacts.size();
  const auto coupled = layout.solver == Solver::Passive ? std::min<std::size_t>(masses, 1024) : 0;
  if (const auto fits = setup.take_memory(64 * layout.elements.size() + coupled * (coupled + contacts) +
                                          2 * contacts * contacts);
      !fits)
    return tl::unexpected(fits.error());
  NetworkRecipe recipe{builder.elements,
                       static_cast<int>(builder.signal_ports.size()),
                       setup.sample_rate,
                       layout.solver,
                       layout.oversample,
                       builder.signal_ports,
                       {},
                       {},
                       {}};
  builder.name_parts(recipe);
  auto network = Network::make(std::move(builder.elements), recipe.signals, recipe.rate, recipe.solver,
                               recipe.oversample);
  if (!network) return tl::unexpected(network.error());
  return std::make_unique<NetworkNode>(std::move(recipe), std::move(*network), builder.readings(),
                                       *setup.type);
}

}  // namespace tactus
