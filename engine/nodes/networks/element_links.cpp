#include "engine/nodes/networks/element_types.h"

namespace tactus {
namespace {

using Ends = ElementType::Ends;

/// A cubic spring is a pair of contacts without a gap between them: their power law is the third.
void build_spring(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  const int first = b.end(e, 0), second = b.end(e, 1);
  const double cubic = b.number(e, "cubic"), rest = b.number(e, "rest");
  parts.spring = b.append(b.elements.springs,
                          Spring{first, second, b.number(e, "stiffness"), b.number(e, "damping"), rest});
  if (cubic == 0.0) return;
  const auto side = [&](int lower, int upper, double offset) {
    return b.append(b.elements.contacts, Contact{.lower = lower,
                                                 .upper = upper,
                                                 .stiffness = cubic,
                                                 .exponent = 3.0,
                                                 .restitution = {},
                                                 .offset = offset});
  };
  parts.contact = side(second, first, -rest);
  parts.opposite = side(first, second, rest);
}

void build_damper(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.spring =
      b.append(b.elements.springs, Spring{b.end(e, 0), b.end(e, 1), 0.0, b.number(e, "damping"), 0.0});
}

void build_coil(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.coil = b.append(b.elements.coils,
                        Coil{b.end(e, 0), b.end(e, 1), b.number(e, "force_factor"), b.number(e, "resistance"),
                             b.number(e, "inductance"), b.signal(e, "voltage")});
}

ElementField cubic() {
  auto field = with_default("cubic", "N/m^3",
                            "cubic stiffness; positive: stiffer at large extension or compression", 0.0, 0.0);
  field.nonlinear = true;
  return field;
}

}  // namespace

std::vector<ElementType> link_elements() {
  return {
      {.name = "spring",
       .doc = "A spring and a damper in parallel. The first end is the lower one.",
       .equation = "force = stiffness e + cubic e^3 + damping e',  e = x_second - x_first - rest",
       .ends = Ends::Between,
       .fields = {required("stiffness", "N/m", "stiffness (force per displacement)", 0.0), cubic(),
                  with_default("damping", "N s/m", "damping coefficient (force per velocity)", 0.0, 0.0),
                  with_default("rest", "m", "length at zero force", 0.0)},
       .quantities = {kTension, kExtension},
       .example = "hold = { type = \"spring\", between = [\"frame\", \"cone\"], stiffness = \"1000 N/m\" }",
       .build = build_spring,
       .gives_force = true},
      {.name = "damper",
       .doc = "A damper between two points.",
       .equation = "force = damping e',  e = x_second - x_first",
       .ends = Ends::Between,
       .fields = {required("damping", "N s/m", "damping coefficient (force per velocity)", 0.0)},
       .quantities = {kTension, kExtension},
       .example = "loss = { type = \"damper\", between = [\"frame\", \"cone\"], damping = \"1.2 kg/s\" }",
       .build = build_damper},
      {.name = "coil",
       .doc = "A voice coil in the field of a magnet, driven by a voltage. The magnet is fixed unless "
              "`against` names a point.",
       .equation = "inductance i' = voltage - resistance i - force_factor (x_on - x_against)',  force = "
                   "force_factor i",
       .ends = Ends::Against,
       .fields = {signal("voltage", "V", "voltage at the terminals, held constant during each frame"),
                  required("force_factor", "T m", "force factor Bl"),
                  required("resistance", "ohm", "resistance of the wire", 1e-3),
                  with_default("inductance", "H", "inductance of the coil", 0.0, 0.0)},
       .quantities = {{"current", "A", "force; positive: pushes `on` up",
                       read_part<&Network::current, &ElementParts::coil>},
                      {"force", "N", "force on `on`", read_part<&Network::coil_force, &ElementParts::coil>}},
       .example =
           "coil = { type = \"coil\", on = \"cone\", voltage = \"10 V * drive\", force_factor = \"6 T m\", "
           "resistance = \"6.5 ohm\" }",
       .build = build_coil},
  };
}

}  // namespace tactus
