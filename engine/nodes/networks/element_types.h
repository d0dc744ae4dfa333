#pragma once

// Thread: [control], except where a function says otherwise
#include <string>
#include <vector>

#include "engine/nodes/declare.h"
#include "engine/nodes/networks/network_builder.h"
#include "engine/nodes/networks/network_elements.h"

// What the declarations of elements share.
namespace tactus {

// Smaller masses and stiffnesses are typing errors, and zero would be divided by.
inline constexpr double kTiny = 1e-9;

inline ElementField required(std::string name, std::string unit, std::string doc, double low = -kLargestField,
                             double high = kLargestField) {
  return {{.name = name, .unit = unit, .doc = doc, .low = low, .high = high, .fixed = true}};
}
inline ElementField with_default(std::string name, std::string unit, std::string doc, double fallback,
                                 double low = -kLargestField, double high = kLargestField) {
  auto field = required(name, unit, doc, low, high);
  field.fallback = fallback;
  return field;
}
inline ElementField if_named(std::string name, std::string unit, std::string doc, double low,
                             double high = kLargestField, std::string instead_of = {},
                             bool one_required = false) {
  return {required(name, unit, doc, low, high), true, instead_of, false, one_required};
}
inline ElementField signal(std::string name, std::string unit, std::string doc,
                           std::optional<double> fallback = {}) {
  return {{.name = name, .unit = unit, .doc = doc, .fallback = fallback, .late = true}};
}

/// A whole number; without a fallback it is required.
inline Setting whole(std::string name, std::string doc, double low, double high, std::string fallback = {}) {
  return within(low, high, {name, Setting::Kind::Integer, doc, {}, fallback, fallback.empty()});
}

/// A quantity of a part; `kAxis`: of so many points further.
template <double (Network::*kValue)(const NetworkState&, int) const noexcept, int ElementParts::*kPart,
          int kAxis = 0, bool kNegative = false>
struct PartRead {
  static constexpr ReadElement::Term kTerm = {kValue, kPart, kAxis, kNegative};
  /// [realtime]
  static double add(double sum, const Network& network, const NetworkState& state,
                    const ElementParts& parts) noexcept {
    const int part = parts.*kPart;
    if (part < 0) return sum;
    const double value = (network.*kValue)(state, part + kAxis);
    return kNegative ? sum - value : sum + value;
  }
};
template <class... Reads>
double sum_of_parts(const Network& network, const NetworkState& state, const ElementParts& parts) {
  double sum = -0.0;  // to which any number can be added
  ((sum = Reads::add(sum, network, state, parts)), ...);
  return sum;
}
template <class... Reads>
ReadElement read_sum() {
  return {{Reads::kTerm...}, sum_of_parts<Reads...>};
}
template <double (Network::*kValue)(const NetworkState&, int) const noexcept, int ElementParts::*kPart,
          int kAxis = 0>
ReadElement read_part() {
  return read_sum<PartRead<kValue, kPart, kAxis>>();
}

using ContactForce = PartRead<&Network::contact_force, &ElementParts::contact>;
using OppositeForce = PartRead<&Network::contact_force, &ElementParts::opposite, 0, true>;

inline const ElementQuantity kPosition = {"position", "m", "height; up is positive",
                                          read_part<&Network::position, &ElementParts::point>()};
inline const ElementQuantity kVelocity = {"velocity", "m/s", "second order, from the last three steps",
                                          read_part<&Network::velocity, &ElementParts::point>()};
/// Of a spring with the contacts that make it stiffer, and of a hand with its push.
inline ReadElement read_tension() {
  return read_sum<PartRead<&Network::spring_force, &ElementParts::spring>,
                  PartRead<&Network::applied_force, &ElementParts::force>, ContactForce, OppositeForce>();
}
inline const ElementQuantity kTension = {"force", "N", "force, positive if it pulls the ends together",
                                         read_tension()};
inline const ElementQuantity kExtension = {"extension", "m", "second end - first end - rest",
                                           read_part<&Network::extension, &ElementParts::spring>()};

}  // namespace tactus
