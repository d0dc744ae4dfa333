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
       .doc = "A force on a mass, held from frame to frame.",
       .equation = "mass x'' = … + force",
       .ends = Ends::On,
       .fields = {signal("force", "N", "up is positive")},
       .quantities = {{"force", "N", "of the frame before",
                       read_part<&Network::applied_force, &ElementParts::force>}},
       .example = "weight = { type = \"force\", on = \"stick\", force = \"-0.3 N\" }",
       .build = build_force},
      {.name = "hand",
       .doc =
           "Holds a mass by a spring and a damper and pushes; both the place that it holds to and the push "
           "move no faster than a hand does (two equal poles, 3 dB down at `bandwidth`).",
       .equation = "force = push + stiffness (x_hand - x) + damping (x_hand' - x')",
       .ends = Ends::On,
       .fields = {with_default("stiffness", "N/m", "of the grip", 0.0, 0.0),
                  with_default("damping", "N s/m", "of the grip", 0.0, 0.0),
                  signal("position", "m", "target position", 0.0),
                  signal("force", "N", "push of the hand besides", 0.0),
                  with_default("bandwidth", "Hz", "3 dB down; 10 Hz is as fast as a hand moves", 8.0, 0.1,
                               10.0)},
       .quantities = {{"force", "N", "on the mass, all of it", tension},
                      {"position", "m", "of the hand", point_position}},
       .example = "hand = { type = \"hand\", on = \"stick\", stiffness = \"10 N/m\", position = \"lift\" }",
       .build = build_hand},
      {.name = "port",
       .doc = "Where a wave of force goes between a mass and something outside: a string, a modal body, the "
              "port of another "
              "network. Two ports of one impedance, each the other's wave, are a passive joint.",
       .equation =
           "force = 2 a - impedance v = a + b,  b = a - impedance v,  a = wave (in), b the output `wave`",
       .ends = Ends::On,
       .fields = {required("impedance", "N s/m", "of the wave", kTiny), signal("wave", "N", "comes in", 0.0)},
       .quantities = {{"wave", "N", "goes out, one frame later",
                       read_part<&Network::wave, &ElementParts::port>},
                      {"force", "N", "on the mass", read_part<&Network::port_force, &ElementParts::port>},
                      kVelocity},
       .example =
           "bridge = { type = \"port\", on = \"body\", impedance = \"0.5 N s/m\", wave = \"-1 * string\" }",
       .build = build_port},
      {.name = "probe",
       .doc = "Reads a mass, for instance one of a chain or a grid.",
       .equation = "x, x' of the mass",
       .ends = Ends::On,
       .quantities = {kPosition, kVelocity},
       .example = "ear = { type = \"probe\", on = \"string.67\" }",
       .build = build_probe},
  };
}

}  // namespace tactus
