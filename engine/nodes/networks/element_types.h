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

/// [realtime] A quantity of one part, as `Network` reads it.
template <double (Network::*read)(const NetworkState&, int) const noexcept, int ElementParts::*part>
double read_part(const Network& network, const NetworkState& state, const ElementParts& parts) {
  return (network.*read)(state, parts.*part);
}

/// [realtime] Force of the contact less that of the one that acts the other way.
inline double contact_force(const Network& network, const NetworkState& state, const ElementParts& parts) {
  return network.contact_force(state, parts.contact) -
         (parts.opposite < 0 ? 0.0 : network.contact_force(state, parts.opposite));
}
/// [realtime] Of a spring with the contacts that make it stiffer, and of a hand with its push.
inline double tension(const Network& network, const NetworkState& state, const ElementParts& parts) {
  return network.spring_force(state, parts.spring) +
         (parts.force < 0 ? 0.0 : network.applied_force(state, parts.force)) +
         (parts.contact < 0 ? 0.0 : contact_force(network, state, parts));
}
/// [realtime] Of the element's own point, or of the one that it is on.
inline double point_position(const Network& network, const NetworkState& state, const ElementParts& parts) {
  return network.position(state, parts.point >= 0 ? parts.point : parts.on);
}
inline double point_velocity(const Network& network, const NetworkState& state, const ElementParts& parts) {
  return network.velocity(state, parts.point >= 0 ? parts.point : parts.on);
}

inline const ElementQuantity kPosition = {"position", "m", "height; up is positive", point_position};
inline const ElementQuantity kVelocity = {"velocity", "m/s", "second order, from the last three steps",
                                          point_velocity};
inline const ElementQuantity kTension = {"force", "N", "force, positive if it pulls the ends together",
                                         tension};
inline const ElementQuantity kExtension = {"extension", "m", "second end - first end - rest",
                                           read_part<&Network::extension, &ElementParts::spring>};

}  // namespace tactus
