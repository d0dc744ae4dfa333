#pragma once

#include <string_view>
#include <vector>

#include "engine/graph/node_type.h"
#include "engine/nodes/networks/network_layout.h"
#include "engine/nodes/networks/network_node.h"
#include "engine/physics/elements.h"

namespace tactus {

/// One output of a network: what to ask which part for.
struct NetworkReading {
  ElementQuantity::Kind kind;
  int part = 0;
  int push = -1;   ///< of a hand: the applied force that adds to its spring
  int plus = -1;   ///< of a spring: the contact that pulls where it is stretched far
  int minus = -1;  ///< of a spring, and of a contact with two sides: the contact that acts the other way
};

/// [control] Turns the words and numbers of `[networks.x]` into masses and links.
class NetworkBuilder {
 public:
  NetworkBuilder(const NetworkLayout& layout, const NodeSetup& setup);

  /// One for each output of the declaration, in its order.
  std::vector<NetworkReading> readings() const;

  /// What the elements are called, by what they have become.
  void name_parts(NetworkRecipe& recipe) const;

  NetworkElements elements;
  std::vector<int> signal_ports;  ///< input of each signal of the network

 private:
  using Element = NetworkLayout::Element;
  /// Which parts of the physical network an element has become; of many points, the first.
  struct Parts {
    int point = -1, spring = -1, contact = -1, opposite = -1, force = -1, coil = -1, friction = -1,
        pluck = -1, port = -1;
  };

  NetworkReading reading(ElementQuantity::Kind kind, const Element& element, const Parts& parts) const;
  int port(const Element& element, std::string_view field) const;
  double number(const Element& element, std::string_view field) const;
  Drive signal(const Element& element, std::string_view field);
  int end(const Element& element, std::size_t which) const;

  void add_points(const Element& element, Parts& parts);
  void add_oscillator(const Element& element, Parts& parts);
  void add_many(const Element& element, Parts& parts);
  void add_link(const Element& element, Parts& parts);
  void add_spring(const Element& element, Parts& parts);
  void add_contact(const Element& element, Parts& parts);
  void add_friction(const Element& element, Parts& parts);
  void add_hand(const Element& element, Parts& parts);
  int ground(double at);

  const NetworkLayout& layout_;
  const NodeSetup& setup_;
  std::vector<Parts> parts_;
};

}  // namespace tactus
