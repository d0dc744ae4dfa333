#include "engine/nodes/networks/element_types.h"

namespace tactus {
namespace {

using Ends = ElementType::Ends;

void build_force(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.force = b.append(b.elements.forces, AppliedForce{parts.on, b.signal(e, "force")});
}

void build_hand(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  const int place = b.signal(e, "position").signal, push = b.signal(e, "force").signal;
  const auto made = attach(b.elements, Hand{parts.on, b.number(e, "stiffness"), b.number(e, "damping"),
                                            Hertz{b.number(e, "bandwidth")}, place, push});
  parts.point = made.point;
  parts.spring = made.spring;
  parts.force = made.force;
}

void build_port(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.port = b.append(b.elements.ports, WavePort{parts.on, b.number(e, "impedance"), b.signal(e, "wave")});
}

void build_probe(NetworkBuilder&, const NetworkElement&, ElementParts&) {}

}  // namespace

std::vector<ElementType> outside_elements() {
  return {
      {.name = "force",
       .doc = "A force on a mass, held constant during each frame.",
       .equation = "mass x'' = … + force",
       .ends = Ends::On,
       .fields = {signal("force", "N", "applied force; up is positive")},
       .quantities = {{"force", "N", "value of the previous frame",
                       read_part<&Network::applied_force, &ElementParts::force>}},
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
       .quantities = {{"force", "N", "total force on the mass", tension},
                      {"position", "m", "position of the hand", point_position}},
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
                       read_part<&Network::wave, &ElementParts::port>},
                      {"force", "N", "force on the mass",
                       read_part<&Network::port_force, &ElementParts::port>},
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
