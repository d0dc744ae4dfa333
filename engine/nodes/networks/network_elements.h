#pragma once

// Thread: [control], except where a function says otherwise
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/graph/node_type.h"
#include "engine/graph/semantics/interval.h"
#include "engine/physics/network.h"

// The table of the elements of networks. All behaviour of an element's type is in its
// entry; generic code reads the entry and never compares names. To add one: a file with its declaration, a
// line in network_builder.cpp, a test.
namespace tactus {

struct ElementType;
class NetworkBuilder;

/// What the axes of an element in space are called: "bob.x".
inline constexpr std::array<char, 3> kAxisNames = {'x', 'y', 'z'};

/// Fixed fields without a range of their own are at most this, of either sign, in SI units: squares and
/// products of a few of them still fit a double.
inline constexpr double kLargestField = 1e30;
/// Of an element: more than the 87,000 that a core steps at 48 kHz. One takes 1.7 to 2.0 kB in a chain or
/// ring: 180 MB.
inline constexpr int kMostMasses = 90'000;

/// A field of an element that takes a number or a signal; becomes the input "element.field" of the network,
/// `late` if it is a signal, else `fixed`. The unit "N/m^exponent" is by the element's own exponent.
struct ElementField : InputPort {
  bool optional = false;        ///< not there at all unless the file names it
  std::string instead_of = {};  ///< the field that it excludes
  bool nonlinear = false;       ///< an element that has it is not linear
  bool one_required = false;    ///< it or the field that it excludes must be in the file
  int axis = 0;                 ///< only of an element with more axes than this
};

/// Which parts of the physical network an element has become; of many points, the first. -1: none.
struct ElementParts {
  int on = -1;  ///< the point that its first end names
  int point = -1, spring = -1, contact = -1, opposite = -1, force = -1, coil = -1, friction = -1, bond = -1,
      port = -1;
};

/// [any] Calls `each(kind, part)` for every part of an element, -1 or not; of many points, for the first.
template <class Parts, class Each>
void for_each_part(Parts& parts, Each each) {
  each(PartKind::Point, parts.point);
  each(PartKind::Spring, parts.spring);
  each(PartKind::Contact, parts.contact);
  each(PartKind::Contact, parts.opposite);
  each(PartKind::Force, parts.force);
  each(PartKind::Coil, parts.coil);
  each(PartKind::Friction, parts.friction);
  each(PartKind::Bond, parts.bond);
  each(PartKind::Port, parts.port);
}

/// What an output shows of a state: the sum of quantities of those parts that an element has, as `Network`
/// reads them. [any]
struct ReadElement {
  struct Term {
    double (Network::*value)(const NetworkState&, int) const noexcept;
    int ElementParts::*part;
    int axis;  ///< so many points further
    bool negative;
  };
  std::vector<Term> terms;
  /// [realtime] Their sum; all in one call.
  double (*sum)(const Network&, const NetworkState&, const ElementParts&);
};

/// A quantity that can be read: the output "element.quantity" of the network.
struct ElementQuantity {
  std::string name;
  std::string unit;
  std::string doc;
  ReadElement read;
  Interval range = {};
  int axis = 0;  ///< only of an element with more axes than this
};

/// An element of `[networks.x]` with its names resolved. Numbers are not known yet.
struct NetworkElement {
  const ElementType* type = nullptr;
  std::string name;
  std::array<int, 2> ends = {-1, -1};  ///< elements, in the order of `between`, or `on` and `against`
  std::array<int, 2> within = {0, 0};  ///< which of their points
  std::vector<int> ports;              ///< input of each field, in the order of the type; -1: not in the file
  std::vector<SettingValue> settings;  ///< in the order of the type
  int pressed_by = -1;                 ///< the element whose force the field `ElementType::force_field` names

  /// Of chains, rings and grids; else 1. Rows are 1 but for grids.
  int rows() const;
  int columns() const;
  /// In which its masses move: x, y and z.
  int axes() const;
  int points() const { return rows() * columns() * axes(); }
  /// Whether it has a field or a quantity.
  template <class Part>
  bool has(const Part& part) const {
    return part.axis == 0 || part.axis < axes();
  }
  bool chosen(std::string_view setting, std::string_view word) const;
};

/// The declaration of a type of element: what is checked, how it is built, what is read, and the reference.
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
  std::vector<Setting> settings = {};  ///< read when the file is
  std::vector<ElementField> fields = {};
  std::vector<ElementQuantity> quantities =
      {};  ///< the first is what the element's bare name means; may be empty
  std::string example;
  /// Adds the element to the physical network.
  void (*build)(NetworkBuilder&, const NetworkElement&, ElementParts&);
  int dimensions = 0;        ///< 1: points "name.1" ...; 2: "name.row.column"; the first settings count them
  bool in_space = false;     ///< its points have several axes, or it joins such points
  bool takes_force = true;   ///< of a point: forces can act on it
  bool linear = true;        ///< its force is proportional to places, speeds and currents, or given
  bool gives_force = false;  ///< a `force_field` may name its force
  std::string force_field = {};  ///< the field that may name another element's force instead of a signal
  /// Whether its outputs take either sign, whatever the range of the quantity. nullptr: no.
  bool (*two_sided)(const NetworkElement&) = nullptr;
};

/// [any] All of them, in the order of the reference.
std::span<const ElementType> network_elements();
/// [any] nullptr if there is no such type.
const ElementType* find_element(std::string_view name);

}  // namespace tactus
