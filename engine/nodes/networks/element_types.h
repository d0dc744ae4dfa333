#pragma once

#include <string>
#include <vector>

#include "engine/nodes/networks/network_elements.h"

// The declarations of all elements of networks, in the order of the reference.
namespace tactus {

std::vector<ElementType> point_elements();    ///< masses, and many of them
std::vector<ElementType> link_elements();     ///< springs, dampers, coils
std::vector<ElementType> contact_elements();  ///< what touches: contacts, frictions, plectra
std::vector<ElementType> outside_elements();  ///< forces, hands, ports, probes

// Smaller masses and stiffnesses are slips of the pen, and zero would be divided by.
inline constexpr double kTiny = 1e-9;

inline ElementField required(std::string name, std::string unit, std::string doc, double low = -kUnlimited,
                             double high = kUnlimited) {
  return {.name = name, .unit = unit, .doc = doc, .low = low, .high = high};
}
inline ElementField with_default(std::string name, std::string unit, std::string doc, double fallback,
                                 double low = -kUnlimited, double high = kUnlimited) {
  return {.name = name, .unit = unit, .doc = doc, .fallback = fallback, .low = low, .high = high};
}
inline ElementField if_named(std::string name, std::string unit, std::string doc, double low,
                             double high = kUnlimited) {
  return {.name = name, .unit = unit, .doc = doc, .low = low, .high = high, .optional = true};
}
inline ElementField signal(std::string name, std::string unit, std::string doc,
                           std::optional<double> fallback = {}) {
  return {.name = name, .unit = unit, .doc = doc, .fallback = fallback, .signal = true};
}

inline const ElementQuantity kPosition = {"position", "m", "height; up is positive",
                                          ElementQuantity::Kind::Position};
inline const ElementQuantity kVelocity = {"velocity", "m/s", "second order, from the last three steps",
                                          ElementQuantity::Kind::Velocity};
inline const ElementQuantity kTension = {"force", "N", "tension: pulls the ends together",
                                         ElementQuantity::Kind::SpringForce};
inline const ElementQuantity kExtension = {"extension", "m", "second end - first end - rest",
                                           ElementQuantity::Kind::Extension};

}  // namespace tactus
