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

void build_force(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.force = b.append(b.elements.forces, AppliedForce{parts.on, b.signal(e, "force")});
}

/// A driven point, a spring and a force.
void build_hand(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  auto place = b.signal(e, "position"), push = b.signal(e, "force");
  place.bandwidth = push.bandwidth = Hertz{b.number(e, "bandwidth")};
  parts.point = b.append(b.elements.points, Point{.kind = Point::Kind::Motion, .input = place});
  parts.spring = b.append(b.elements.springs, Spring{parts.on, parts.point, b.number(e, "stiffness"),
                                                     b.number(e, "damping"), 0.0});
  parts.force = b.append(b.elements.forces, AppliedForce{parts.on, push});
}

void build_port(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.port = b.append(b.elements.ports, WavePort{parts.on, b.number(e, "impedance"), b.signal(e, "wave")});
}

void build_probe(NetworkBuilder&, const NetworkElement&, ElementParts&) {}

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
                       read_part<&Network::current, &ElementParts::coil>()},
                      {"force", "N", "force on `on`",
                       read_part<&Network::coil_force, &ElementParts::coil>()}},
       .example =
           "coil = { type = \"coil\", on = \"cone\", voltage = \"10 V * drive\", force_factor = \"6 T m\", "
           "resistance = \"6.5 ohm\" }",
       .build = build_coil},
  };
}

std::vector<ElementType> outside_elements() {
  return {
      {.name = "force",
       .doc = "A force on a mass, held constant during each frame.",
       .equation = "mass x'' = … + force",
       .ends = Ends::On,
       .fields = {signal("force", "N", "applied force; up is positive")},
       .quantities = {{"force", "N", "value of the previous frame",
                       read_part<&Network::applied_force, &ElementParts::force>()}},
       .example = "weight = { type = \"force\", on = \"stick\", force = \"-0.3 N\" }",
       .build = build_force},
      {.name = "hand",
       .doc = "A hand: holds a mass by a spring and a damper, and pushes. The held position and the push are "
              "low-pass filtered to the speed of a hand (two equal poles, -3 dB at `bandwidth`).",
       .equation = "force = push + stiffness (x_hand - x) + damping (x_hand' - x')",
       .ends = Ends::On,
       .fields = {with_default("stiffness", "N/m", "stiffness of the grip", 0.0, 0.0),
                  with_default("damping", "N s/m", "damping of the grip", 0.0, 0.0),
                  signal("position", "m", "target position", 0.0),
                  signal("force", "N", "additional push of the hand", 0.0),
                  with_default(
                      "bandwidth", "Hz",
                      "bandwidth of the hand's movement (-3 dB); 10 Hz is the fastest for a real hand", 8.0,
                      0.1, 10.0)},
       .quantities = {{"force", "N", "total force on the mass", read_tension()},
                      {"position", "m", "position of the hand",
                       read_part<&Network::position, &ElementParts::point>()}},
       .example = "hand = { type = \"hand\", on = \"stick\", stiffness = \"10 N/m\", position = \"lift\" }",
       .build = build_hand},
      {.name = "port",
       .doc = "A port exchanges a force wave between a mass and an external model: a string, a modal body, "
              "the port of another network. Two ports of equal impedance, each fed with the other's wave, "
              "form a passive connection.",
       .equation =
           "force = 2 a - impedance v = a + b,  b = a - impedance v,  a = wave (in), b the output `wave`",
       .ends = Ends::On,
       .fields = {required("impedance", "N s/m", "wave impedance", kTiny),
                  signal("wave", "N", "incoming wave", 0.0)},
       .quantities = {{"wave", "N", "outgoing wave, one frame later",
                       read_part<&Network::wave, &ElementParts::port>()},
                      {"force", "N", "force on the mass",
                       read_part<&Network::port_force, &ElementParts::port>()},
                      kVelocity},
       .example =
           "bridge = { type = \"port\", on = \"body\", impedance = \"0.5 N s/m\", wave = \"-1 * string\" }",
       .build = build_port},
      {.name = "probe",
       .doc = "Reads the state of a mass, for instance of one mass of a chain or grid.",
       .equation = "x, x' of the mass",
       .ends = Ends::On,
       .quantities = {kPosition, kVelocity},
       .example = "ear = { type = \"probe\", on = \"string.67\" }",
       .build = build_probe},
  };
}

}  // namespace tactus
