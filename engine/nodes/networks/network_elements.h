#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/graph/node_type.h"
#include "engine/graph/semantics/interval.h"

namespace tactus {

/// A field of an element that takes a number or a signal; becomes the input "element.field" of the network.
struct ElementField {
  std::string name;
  std::string unit;  ///< as InputPort::unit; "N/m^exponent": by the element's own exponent
  std::string doc;
  std::optional<double> fallback = {};
  double low = -kUnlimited;
  double high = kUnlimited;
  bool signal = false;    ///< may change from frame to frame; others are fixed when the graph is loaded
  bool optional = false;  ///< not there at all unless the file names it
};

/// What a network can be asked for: the output "element.quantity".
struct ElementQuantity {
  enum class Kind {
    Position,
    Velocity,
    Extension,
    SpringForce,
    Indentation,
    ContactForce,
    AppliedForce,
    Current,
    CoilForce,
    FrictionForce,
    FrictionVelocity,
    PluckForce,
    Wave,
    PortForce,
    Energy,
  };
  std::string name;
  std::string unit;
  std::string doc;
  Kind kind;
  Interval range = {};
};

/// The declaration of a kind of element: what is checked, the ports of networks, and the reference.
struct ElementType {
  /// Which fields name other elements.
  enum class Ends {
    None,     ///< it is a point itself, or many
    On,       ///< `on`: a mass
    Against,  ///< `on`: a point; `against`: another one, or none for a fixed place
    Between,  ///< `between`: two points, the lower one first
  };
  std::string name;
  std::string doc;
  std::string equation;
  Ends ends;
  std::vector<Setting> settings;  ///< read when the file is
  std::vector<ElementField> fields;
  std::vector<ElementQuantity> quantities;  ///< the first is what the element's bare name means; may be empty
  std::string example;
  bool many = false;  ///< points "name.1" ..., or "name.row.column"
};

/// [any] All of them, in the order of the reference.
std::span<const ElementType> network_elements();
/// nullptr if there is no such type.
const ElementType* find_element(std::string_view name);

}  // namespace tactus
