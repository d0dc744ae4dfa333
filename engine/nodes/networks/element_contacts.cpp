#include <algorithm>
#include <memory>
#include <utility>

#include "engine/nodes/networks/element_types.h"

namespace tactus {
namespace {

using Ends = ElementType::Ends;

bool has_two_sides(const NetworkElement& e) { return e.settings[0].number == 2.0; }

void build_contact(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  Contact contact{b.end(e, 0),         b.end(e, 1), b.number(e, "stiffness"), b.number(e, "exponent"),
                  b.number(e, "loss"), {},          b.number(e, "offset")};
  if (b.has(e, "restitution")) contact.restitution = b.number(e, "restitution");
  if (has_two_sides(e)) {
    auto opposite = contact;
    std::swap(opposite.lower, opposite.upper);
    opposite.offset = -contact.offset - b.number(e, "clearance");
    contact.offset -= b.number(e, "clearance");
    parts.opposite = b.append(b.elements.contacts, opposite);
  }
  parts.contact = b.append(b.elements.contacts, contact);
}

ElementType contact() {
  return {
      .name = "contact",
      .doc =
          "Two surfaces in contact: they push and never pull. The first is below the second. With "
          "`restitution`, the loss is set at each impact to give this ratio of the speeds after and before.",
      .equation = "force = max(0, stiffness n^exponent (1 + loss n')),  n = x_first - x_second + offset > 0",
      .ends = Ends::Between,
      .settings = {whole("sides",
                         "2: the first point moves in a gap of the second, with contact below and above; the "
                         "force is then signed",
                         1, 2, "1")},
      .fields = {required("stiffness", "N/m^exponent", "stiffness: force at an indentation of 1 m", kTiny),
                 with_default("exponent", "", "exponent; 1: linear, 1.5: a sphere on a plane (Hertz)", 1.5,
                              1.0, 10.0),
                 with_default("loss", "s/m", "Hunt-Crossley loss", 0.0, 0.0),
                 if_named("restitution", "", "speed after / speed before an impact, instead of `loss`", 0.01,
                          1.0, "loss"),
                 with_default("offset", "m", "indentation when both points have the same position", 0.0),
                 with_default("clearance", "m", "for a two-sided contact: free travel in each direction", 0.0,
                              0.0)},
      .quantities = {{"force",
                      "N",
                      "contact force; negative only with `sides` = 2",
                      read_sum<ContactForce, OppositeForce>(),
                      {0.0, kUnlimited}},
                     {"indentation",
                      "m",
                      "indentation; negative only with `sides` = 2",
                      read_sum<PartRead<&Network::indentation, &ElementParts::contact>,
                               PartRead<&Network::indentation, &ElementParts::opposite, 0, true>>(),
                      {0.0, kUnlimited}}},
      .example =
          "lens = { type = \"contact\", between = [\"cone\", \"stick\"], stiffness = \"5e6 N/m^1.5\" }",
      .build = build_contact,
      .linear = false,
      .gives_force = true,
      .two_sided = has_two_sides};
}

void build_friction(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  Friction friction{
      .lower = b.end(e, 0), .upper = b.end(e, 1), .law = {}, .viscous = b.number(e, "viscous"), .normal = {}};
  if (e.chosen("law", "rosin")) {
    friction.law = kRosin;
  } else {
    friction.law.kinetic = b.number(e, "kinetic");
    const double drop = b.has(e, "holding") ? b.number(e, "holding") - friction.law.kinetic : 0.0;
    friction.law.drops[0] = {std::max(0.0, drop), b.number(e, "speed")};
  }
  if (e.pressed_by >= 0) {
    const auto& link = b.parts(e.pressed_by);
    friction.normal_spring = link.spring;
    if (link.spring < 0) friction.normal_contact = link.contact;
  } else {
    friction.normal = b.signal(e, "normal");
  }
  parts.friction = b.append(b.elements.frictions, friction);
}

ElementType friction() {
  return {
      .name = "friction",
      .doc =
          "Friction between two points: a bow on a string, a brake, a dry bearing. They stick up to a force "
          "of normal * holding; when sliding, the coefficient falls to `kinetic`. `normal` is a signal, or "
          "the force of a "
          "contact or a spring of this network, as in normal = \"press.force\".",
      .equation =
          "force = normal mu(|v|) sgn v + viscous v,  v = x_first' - x_second',  mu(v) = kinetic + (holding "
          "- "
          "kinetic) exp(-v / speed);  rosin: mu(v) = 0.35 + 0.4 exp(-v / 0.01 m/s) + 0.45 exp(-v / 0.1 m/s)",
      .ends = Ends::Between,
      .settings = {choice("law", "friction law; rosin: with its own coefficients", {"falling", "rosin"},
                          "falling")},
      .fields = {signal("normal", "N",
                        "normal force, pressing the points together; negative values count as 0"),
                 with_default("kinetic", "", "friction coefficient at high sliding speed", 0.3, 0.0),
                 if_named("holding", "", "static friction coefficient; default: `kinetic` (Coulomb)", 0.0),
                 with_default("speed", "m/s", "sliding speed that scales the fall of the coefficient", 0.1,
                              1e-6),
                 with_default("viscous", "N s/m", "viscous friction of a lubricant", 0.0, 0.0)},
      .quantities =
          {{"force", "N",
            "friction force of the last step; positive: drags the second point along with the first",
            read_part<&Network::friction_force, &ElementParts::friction>()},
           {"velocity", "m/s", "sliding velocity; 0: sticking",
            read_part<&Network::friction_velocity, &ElementParts::friction>()}},
      .example =
          "hair = { type = \"friction\", between = [\"bow\", \"string\"], normal = \"0.5 N\", law = "
          "\"rosin\" }",
      .build = build_friction,
      .linear = false,
      .force_field = "normal"};
}

void build_pluck(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.bond = b.append(b.elements.bonds,
                        Bond{b.end(e, 0), b.end(e, 1), std::make_shared<LinearBond>(b.number(e, "stiffness")),
                             b.number(e, "damping"), b.number(e, "limit")});
}

ElementType pluck() {
  return {
      .name = "pluck",
      .doc =
          "A plectrum: pulls a point along until the force exceeds `limit`, then releases it, and catches it "
          "again when the two points meet.",
      .equation = "force = stiffness n + damping n',  n = x_first - x_second,  while stiffness |n| <= limit",
      .ends = Ends::Between,
      .fields = {required("stiffness", "N/m", "stiffness of the plectrum", kTiny),
                 with_default("damping", "N s/m", "damping of the plectrum", 0.0, 0.0),
                 required("limit", "N", "force at which it releases", kTiny)},
      .quantities = {{"force", "N", "force, positive if it pulls the second point along with the first",
                      read_part<&Network::bond_force, &ElementParts::bond>()}},
      .example =
          "plectrum = { type = \"pluck\", between = [\"pick\", \"string\"], stiffness = \"500 N/m\", "
          "limit = \"2 N\" }",
      .build = build_pluck,
      .linear = false};
}

}  // namespace

std::vector<ElementType> contact_elements() { return {contact(), friction(), pluck()}; }

}  // namespace tactus
