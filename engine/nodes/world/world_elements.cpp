#include "engine/nodes/world/world_elements.h"

#include <utility>

#include "engine/core/named.h"
#include "engine/nodes/networks/element_types.h"

namespace tactus {
namespace {

using Ends = WorldElementType::Ends;
using Fields = std::vector<ElementField>;

/// A signal that need not be given: without it nothing of it is computed.
ElementField optional_signal(std::string name, std::string unit, std::string doc) {
  return {{.name = name, .unit = unit, .doc = doc, .late = true}, true};
}
/// A signal that acts in the same frame.
ElementField prompt_signal(std::string name, std::string unit, std::string doc) {
  return {{.name = name, .unit = unit, .doc = doc}, true};
}
ElementField within_range(ElementField field, double low, double high) {
  field.low = low;
  field.high = high;
  return field;
}

Setting vector_setting(std::string name, std::string unit, std::string doc, bool required = false) {
  Setting setting{std::move(name), Setting::Kind::Numbers, std::move(doc), {std::move(unit)}};
  setting.required = required;
  return setting;
}

Fields joined_fields(std::initializer_list<Fields> groups) {
  Fields all;
  for (const auto& group : groups) all.insert(all.end(), group.begin(), group.end());
  return all;
}

Fields place_fields() {
  return {signal("x", "m", "where it is put", 0.0),
          signal("y", "m", "where it is put", 0.0),
          signal("z", "m", "where it is put; up is positive", 0.0),
          signal("vx", "m/s", "velocity that it is given", 0.0),
          signal("vy", "m/s", "velocity that it is given", 0.0),
          signal("vz", "m/s", "velocity that it is given", 0.0),
          signal("fx", "N", "force at its centre", 0.0),
          signal("fy", "N", "force at its centre", 0.0),
          signal("fz", "N", "force at its centre", 0.0)};
}

Fields matter_fields() {
  auto density = optional_signal("density", "kg/m^3", "density; mass = density x volume");
  density.instead_of = "mass";
  density.one_required = true;
  return {within_range(optional_signal("mass", "kg", "mass, spread evenly"), kLeastMass_kg, kUnlimited),
          density};
}

Fields surface_fields() {
  return {with_default("friction", "",
                       "Coulomb's coefficient; of two bodies in contact the geometric mean of theirs acts",
                       0.5, 0.0),
          with_default("restitution", "",
                       "speed after an impact over speed before it; of two bodies the larger acts", 0.0, 0.0,
                       1.0)};
}

Fields presence_fields() {
  return {signal("place", "", "a trigger: the body is put at x, y, z, turned as at first", 0.0),
          signal("launch", "", "a trigger: the body is given the velocity vx, vy, vz and turns no more", 0.0),
          within_range(
              signal("present", "",
                     "below 0.5 the body is not there; when it rises the body is placed and launched", 1.0),
              0, 1)};
}

Setting remote_setting() {
  return choice(kRemote,
                "yes: each signal that is a number or left out is a control, called world_element_field, "
                "which OSC messages change at once",
                {"no", kRemoteYes}, "no");
}

std::vector<Setting> body_settings() {
  return {choice(kMotionOfBody, "fixed: nothing moves it", {"moving", kFixedBody}, "moving"),
          choice(kCollides, "none: it passes through everything", {"all", kCollidesNot}, "all"),
          vector_setting("turn", "rad",
                         "how it is turned at first: an axis of rotation times the angle; default: not"),
          remote_setting()};
}

std::vector<WorldQuantity> body_quantities() {
  constexpr auto kLine = WorldReading::Line;
  return {{"x", "m", "position of its centre", kLine},
          {"y", "m", "position of its centre", kLine},
          {"z", "m", "position of its centre; up is positive", kLine},
          {"vx", "m/s", "velocity of its centre"},
          {"vy", "m/s", "velocity of its centre"},
          {"vz", "m/s", "velocity of its centre"},
          {"wx", "rad/s", "angular velocity"},
          {"wy", "rad/s", "angular velocity"},
          {"wz", "rad/s", "angular velocity"}};
}

constexpr auto kNewton = "m dv/dt = m g + (fx, fy, fz) + forces,  d(I w)/dt = torques";

WorldElementType body(std::string name, WorldShape shape, std::string doc, Fields sizes,
                      std::string example) {
  return {.name = std::move(name),
          .doc = std::move(doc),
          .equation = kNewton,
          .part = WorldPart::Body,
          .ends = Ends::None,
          .settings = body_settings(),
          .fields = joined_fields(
              {std::move(sizes), matter_fields(), place_fields(), surface_fields(), presence_fields()}),
          .quantities = body_quantities(),
          .example = std::move(example),
          .shape = shape};
}

ElementField size_field(std::string name, std::string doc) {
  return within_range(signal(std::move(name), "m", std::move(doc)), kLeastSize_m, kUnlimited);
}

WorldElementType plane() {
  return {.name = "plane",
          .doc = "A fixed plane; what is below it is pushed out.",
          .equation = "n . p = offset,  n the unit vector along normal",
          .part = WorldPart::Body,
          .ends = Ends::None,
          .settings = {vector_setting("normal", "", "direction that points out of the solid", true)},
          .fields =
              joined_fields({{with_default("offset", "m", "distance from the origin along the normal", 0.0)},
                             surface_fields()}),
          .example = "floor = { type = \"plane\", normal = [0, 0, 1] }",
          .shape = WorldShape::Plane};
}

Fields anchor_fields() {
  return {with_default("x", "m", "a point of the joint, in the world", 0.0),
          with_default("y", "m", "a point of the joint, in the world", 0.0),
          with_default("z", "m", "a point of the joint, in the world", 0.0)};
}

Fields stop_fields(const std::string& unit) {
  return {if_named("low", unit, "stop at the lower end", -kLargestField),
          if_named("high", unit, "stop at the upper end", -kLargestField)};
}

WorldElementType joint(std::string name, WorldJoint kind, std::string doc, std::string equation,
                       std::vector<Setting> settings, Fields fields, std::vector<WorldQuantity> quantities,
                       std::string example) {
  return {.name = std::move(name),
          .doc = std::move(doc),
          .equation = std::move(equation),
          .part = WorldPart::Joint,
          .ends = Ends::Against,
          .settings = std::move(settings),
          .fields = std::move(fields),
          .quantities = std::move(quantities),
          .example = std::move(example),
          .joint = kind};
}

Fields link_fields() {
  const auto body_field = [](const char* name, const char* doc) {
    return within_range(signal(name, "", doc, 0.0), 0, kMostBodies);
  };
  const auto least_zero = [](const char* name, const char* doc) {
    return within_range(signal(name, "", doc, 0.0), 0, kLargestField);
  };
  std::string kinds = "0: none";
  for (int k = 0; k < kJointKinds; ++k)
    kinds += ", " + std::to_string(k + 1) + ": " + kJointNames[static_cast<std::size_t>(k)];
  return {within_range(signal("kind", "", std::move(kinds), 0.0), 0, kJointKinds),
          body_field("first", "number of a body, in the order of the file, from 1"),
          body_field("second", "number of the other body; 0: the world"),
          signal("x", "m", "a point of the joint, in the world", 0.0),
          signal("y", "m", "a point of the joint, in the world", 0.0),
          signal("z", "m", "a point of the joint, in the world", 0.0),
          signal("ax", "", "first axis, in the world", 0.0),
          signal("ay", "", "first axis, in the world", 0.0),
          signal("az", "", "first axis, in the world", 1.0),
          signal("bx", "", "second axis, in the world", 0.0),
          signal("by", "", "second axis, in the world", 1.0),
          signal("bz", "", "second axis, in the world", 0.0),
          signal("attach", "", "a trigger: the joint is made as the numbers above say", 0.0),
          least_zero("stiffness", "back to where it was made, of each axis; SI"),
          least_zero("damping", "of each axis; SI"),
          signal("effort", "", "torque or force of the first axis; SI", 0.0),
          signal("effort2", "", "torque of the second axis; SI", 0.0)};
}

std::vector<WorldElementType> make_elements() {
  const auto axis = [](const char* doc) {
    return std::vector<Setting>{vector_setting("axis", "", doc, true)};
  };
  return {
      body("sphere", WorldShape::Sphere, "A ball.", {size_field("radius", "radius")},
           "ball = { type = \"sphere\", radius = \"2 cm\", mass = \"30 g\", z = \"0.5 m\" }"),
      body("box", WorldShape::Box, "A block with edges along x, y and z.",
           {size_field("width", "size along x"), size_field("depth", "size along y"),
            size_field("height", "size along z")},
           "block = { type = \"box\", width = \"4 cm\", depth = \"4 cm\", height = \"2 cm\", density = \"600 "
           "kg/m^3\" }"),
      body("capsule", WorldShape::Capsule, "A cylinder along z with half a ball at each end.",
           {size_field("radius", "radius"), size_field("length", "length without the ends")},
           "rod = { type = \"capsule\", radius = \"5 mm\", length = \"20 cm\", mass = \"0.1 kg\" }"),
      plane(),
      joint("hinge", WorldJoint::Hinge, "Turns about one axis, on which the torque acts.",
            "only the angle about axis through (x, y, z) is free",
            axis("direction of the axis, in the world"),
            joined_fields(
                {anchor_fields(), stop_fields("rad"), {signal("torque", "N m", "torque on `on`", 0.0)}}),
            {{"angle", "rad", "from where it was at first, within half a turn"},
             {"rate", "rad/s", "its rate of change"}},
            "arm_axis = { type = \"hinge\", on = \"rod\", axis = [0, 1, 0], z = \"0.1 m\" }"),
      joint("slider", WorldJoint::Slider, "Slides along one axis without turning.",
            "only the distance along axis is free", axis("direction of the motion, in the world"),
            joined_fields({stop_fields("m"), {signal("force", "N", "force on `on` along the axis", 0.0)}}),
            {{"position", "m", "from where it was at first", WorldReading::Line},
             {"rate", "m/s", "its rate of change"}},
            "rail = { type = \"slider\", on = \"block\", axis = [1, 0, 0] }"),
      joint("ball", WorldJoint::Ball, "Holds one point of both bodies together.", "the three angles are free",
            {}, anchor_fields(), {}, "hook = { type = \"ball\", on = \"ball\", z = \"0.6 m\" }"),
      joint("fixed", WorldJoint::Fixed, "Holds both bodies as they are to each other.", "nothing is free", {},
            {}, {}, "glue = { type = \"fixed\", on = \"ball\", against = \"block\" }"),
      {.name = "link",
       .doc =
           "A joint between any two bodies, of any kind, that signals or messages make, change and remove.",
       .equation = "torque or force = effort - stiffness q - damping dq/dt,  q the angle or the distance",
       .part = WorldPart::Link,
       .ends = Ends::None,
       .settings = {remote_setting()},
       .fields = link_fields(),
       .example = "link_1 = { type = \"link\", remote = \"yes\" }"},
      {.name = "handle",
       .doc = "A haptic handle, coupled to a body by a spring and a damper along each axis that is given. A "
              "passivity controller removes the energy that sampling generates.",
       .equation =
           "f = stiffness (p - c) + (damping + b) (vp - vc) on the body at c,  -f on the handle at p,\n"
           "0 <= b <= passivity, above 0 while the coupling has given more energy than it took",
       .part = WorldPart::Handle,
       .ends = Ends::On,
       .settings = {remote_setting()},
       .fields = {prompt_signal("x", "m", "position of the handle along x"),
                  prompt_signal("y", "m", "position of the handle along y"),
                  prompt_signal("z", "m", "position of the handle along z"),
                  required("stiffness", "N/m", "stiffness of the coupling", 0.0),
                  with_default("damping", "N s/m", "damping of the coupling", 0.0, 0.0),
                  with_default("passivity", "N s/m",
                               "largest damping that the passivity controller adds; 0: none", 1.0, 0.0),
                  within_range(
                      signal("holds", "",
                             "number of the body that it holds, in the order of the file, from 1; 0: "
                             "none; -1: `on`",
                             -1.0),
                      -1, kMostBodies)},
       .quantities = {{"fx", "N", "force on the handle along x", WorldReading::Frame},
                      {"fy", "N", "force on the handle along y", WorldReading::Frame},
                      {"fz", "N", "force on the handle along z", WorldReading::Frame},
                      {"generated", "J", "energy that sampling generated and the controller has not removed",
                       WorldReading::Held}},
       .example = "hand = { type = \"handle\", on = \"ball\", x = \"position\", stiffness = \"200 N/m\" }"},
      {.name = "gravity",
       .doc = "Acceleration of every body.",
       .equation = "m dv/dt = m (x, y, z) + ...",
       .part = WorldPart::Gravity,
       .ends = Ends::None,
       .settings = {remote_setting()},
       .fields = {signal("x", "m/s^2", "acceleration along x", 0.0),
                  signal("y", "m/s^2", "acceleration along y", 0.0),
                  signal("z", "m/s^2", "acceleration along z", -9.81)},
       .example = "gravity = { type = \"gravity\" }"},
      {.name = "collision",
       .doc = "Impacts of a body against another one, or against anything.",
       .equation = "impulse = sum of the normal forces of the step x its duration = m (1 + restitution) v",
       .part = WorldPart::Collision,
       .ends = Ends::Against,
       .fields = {with_default("least_speed", "m/s", "slower contacts are no impacts", 0.02, 0.0)},
       .quantities = {{"hit", "", "a contact began", WorldReading::Trigger},
                      {"impulse", "N s", "impulse of the last impact", WorldReading::Held, true},
                      {"speed", "m/s", "speed of approach of the last impact"},
                      {"x", "m", "where the last impact was"},
                      {"y", "m", "where the last impact was"},
                      {"z", "m", "where the last impact was"}},
       .example = "knock = { type = \"collision\", on = \"ball\", against = \"block\" }"},
  };
}

}  // namespace

std::span<const WorldElementType> world_elements() {
  static const auto elements = make_elements();
  return elements;
}

const WorldElementType* find_world_element(std::string_view name) {
  const auto all = world_elements();
  return find_named(all, name);
}

}  // namespace tactus
