#include "engine/nodes/network_elements.h"

namespace tactus {
namespace {

using Kind = ElementQuantity::Kind;
using Ends = ElementType::Ends;

// Smaller masses and stiffnesses are slips of the pen, and zero would be divided by.
constexpr double kTiny = 1e-9;

ElementField required(std::string name, std::string unit, std::string doc, double low = -kUnlimited,
                      double high = kUnlimited) {
  return {.name = name, .unit = unit, .doc = doc, .low = low, .high = high};
}
ElementField with_default(std::string name, std::string unit, std::string doc, double fallback,
                          double low = -kUnlimited, double high = kUnlimited) {
  return {.name = name, .unit = unit, .doc = doc, .fallback = fallback, .low = low, .high = high};
}
ElementField signal(std::string name, std::string unit, std::string doc,
                    std::optional<double> fallback = {}) {
  return {.name = name, .unit = unit, .doc = doc, .fallback = fallback, .signal = true};
}

const ElementQuantity kPosition = {"position", "m", "height; up is positive", Kind::Position};
const ElementQuantity kVelocity = {"velocity", "m/s", "second order, from the last three steps",
                                   Kind::Velocity};
const ElementQuantity kTension = {"force", "N", "tension: pulls the ends together", Kind::SpringForce};
const ElementQuantity kExtension = {"extension", "m", "second end - first end - rest", Kind::Extension};

std::vector<ElementType> all_elements() {
  return {
      {.name = "mass",
       .doc = "A body that moves along the network's axis.",
       .equation = "mass x'' = sum of the forces on it",
       .ends = Ends::None,
       .fields = {required("mass", "kg", "moved mass", kTiny),
                  with_default("at", "m", "position at the start", 0.0),
                  with_default("velocity", "m/s", "velocity at the start", 0.0)},
       .quantities = {kPosition, kVelocity},
       .example = "stick = { type = \"mass\", mass = \"12.5 g\", at = \"20 mm\" }"},
      {.name = "ground",
       .doc = "A fixed point.",
       .equation = "x = at",
       .ends = Ends::None,
       .fields = {with_default("at", "m", "position", 0.0)},
       .quantities = {},
       .example = "frame = { type = \"ground\" }"},
      {.name = "motion",
       .doc =
           "A point that goes where a signal says, in a straight line from frame to frame, one frame later.",
       .equation = "x[n + 1] = position[n]",
       .ends = Ends::None,
       .fields = {signal("position", "m", "where it goes")},
       .quantities = {kPosition, kVelocity},
       .example = "table = { type = \"motion\", position = \"shake\" }"},
      {.name = "spring",
       .doc = "A spring with a damper beside it. The first end is the lower one.",
       .equation = "force = stiffness e + damping e',  e = x_second - x_first - rest",
       .ends = Ends::Between,
       .fields = {required("stiffness", "N/m", "force for a metre", 0.0),
                  with_default("damping", "N s/m", "force for a metre a second", 0.0, 0.0),
                  with_default("rest", "m", "length without force", 0.0)},
       .quantities = {kTension, kExtension},
       .example = "hold = { type = \"spring\", between = [\"frame\", \"cone\"], stiffness = \"1000 N/m\" }"},
      {.name = "damper",
       .doc = "A damper between two points.",
       .equation = "force = damping e',  e = x_second - x_first",
       .ends = Ends::Between,
       .fields = {required("damping", "N s/m", "force for a metre a second", 0.0)},
       .quantities = {kTension, kExtension},
       .example = "loss = { type = \"damper\", between = [\"frame\", \"cone\"], damping = \"1.2 kg/s\" }"},
      {.name = "contact",
       .doc =
           "Two surfaces that push and never pull. The first one is below the second. With `restitution` the "
           "loss is set at each touch, so that the speeds before and after have this ratio.",
       .equation = "force = max(0, stiffness n^exponent (1 + loss n')),  n = x_first - x_second + offset > 0",
       .ends = Ends::Between,
       .fields = {required("stiffness", "N/m^exponent", "force at an indentation of 1 m", kTiny),
                  with_default("exponent", "", "1 linear, 1.5 a ball on a flat (Hertz)", 1.5, 1.0, 10.0),
                  with_default("loss", "s/m", "Hunt-Crossley loss", 0.0, 0.0),
                  {.name = "restitution",
                   .unit = "",
                   .doc = "speed after / speed before, instead of `loss`",
                   .low = 0.01,
                   .high = 1.0,
                   .optional = true},
                  with_default("offset", "m", "indentation where both points are at one place", 0.0)},
       .quantities = {{"force", "N", "push, never below 0", Kind::ContactForce, {0.0, kUnlimited}},
                      {"indentation", "m", "how deep, never below 0", Kind::Indentation, {0.0, kUnlimited}}},
       .example =
           "lens = { type = \"contact\", between = [\"cone\", \"stick\"], stiffness = \"5e6 N/m^1.5\" }"},
      {.name = "force",
       .doc = "A force on a mass, held from frame to frame.",
       .equation = "mass x'' = … + force",
       .ends = Ends::On,
       .fields = {signal("force", "N", "up is positive")},
       .quantities = {{"force", "N", "of the frame before", Kind::AppliedForce}},
       .example = "weight = { type = \"force\", on = \"stick\", force = \"-0.3 N\" }"},
      {.name = "hand",
       .doc =
           "Holds a mass by a spring and a damper and pushes; both the place that it holds to and the push "
           "move no faster than a hand does (two equal poles, 3 dB down at `bandwidth`).",
       .equation = "force = push + stiffness (x_hand - x) + damping (x_hand' - x')",
       .ends = Ends::On,
       .fields = {with_default("stiffness", "N/m", "of the grip", 0.0, 0.0),
                  with_default("damping", "N s/m", "of the grip", 0.0, 0.0),
                  signal("position", "m", "where the hand wants to be", 0.0),
                  signal("force", "N", "how the hand pushes besides", 0.0),
                  with_default("bandwidth", "Hz", "3 dB down; nobody moves faster than 10 Hz", 8.0, 0.1,
                               10.0)},
       .quantities = {{"force", "N", "on the mass, all of it", Kind::SpringForce},
                      {"position", "m", "of the hand", Kind::Position}},
       .example = "hand = { type = \"hand\", on = \"stick\", stiffness = \"10 N/m\", position = \"lift\" }"},
      {.name = "coil",
       .doc =
           "A coil in the field of a magnet, driven by a voltage. Its magnet is fixed unless `against` names "
           "a point.",
       .equation = "inductance i' = voltage - resistance i - force_factor (x_on - x_against)',  force = "
                   "force_factor i",
       .ends = Ends::Against,
       .fields = {signal("voltage", "V", "at its terminals, held from frame to frame"),
                  required("force_factor", "T m", "Bl"), required("resistance", "ohm", "of the wire", 1e-3),
                  with_default("inductance", "H", "of the coil", 0.0, 0.0)},
       .quantities = {{"current", "A", "pushes `on` up where positive", Kind::Current},
                      {"force", "N", "on `on`", Kind::CoilForce}},
       .example =
           "coil = { type = \"coil\", on = \"cone\", voltage = \"10 V * drive\", force_factor = \"6 T m\", "
           "resistance = \"6.5 ohm\" }"},
  };
}

}  // namespace

std::span<const ElementType> network_elements() {
  static const std::vector<ElementType> elements = all_elements();
  return elements;
}

const ElementType* find_element(std::string_view name) {
  for (const auto& element : network_elements())
    if (element.name == name) return &element;
  return nullptr;
}

}  // namespace tactus
