#include "engine/nodes/world/world_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/index.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/world/world_use.h"

namespace tactus {
namespace {

/// Until a signal that gives it is known.
constexpr double kUnknownSize_m = 0.01, kUnknownMass_kg = 0.01;

class WorldBuilder {
 public:
  WorldBuilder(const WorldLayout& layout, const NodeSetup& setup)
      : layout_(layout), setup_(setup), used_(find_used(layout, setup)) {}

  WorldRecipe run() {
    recipe_.needed.assign(setup_.type->inputs.size(), false);
    build_bodies();
    for (const auto part :
         {WorldPart::Joint, WorldPart::Link, WorldPart::Handle, WorldPart::Gravity, WorldPart::Collision})
      for (std::size_t i = 0; i < layout_.elements.size(); ++i)
        if (used_.kept[i] && layout_.elements[i].type->part == part) build(i);
    build_outputs();
    set_options();
    report_left_out();
    return std::move(recipe_);
  }

 private:
  using Element = WorldElement;

  /// The value of a constant; of a signal that may change, `otherwise`.
  double number(const Element& of, std::string_view field, double otherwise = 0) const {
    const int at = of.port(field);
    if (at < 0) return otherwise;
    const auto& port = setup_.type->inputs[index(at)];
    const auto& info = setup_.inputs[index(at)];
    const double value = info.constant    ? *info.constant
                         : info.connected ? otherwise
                                          : port.fallback.value_or(otherwise);
    return std::clamp(value, port.low, port.high);
  }

  WorldInput input(const Element& of, std::string_view field, double otherwise = 0) {
    const int at = of.port(field);
    if (at >= 0) recipe_.needed[index(at)] = true;
    return {at, number(of, field, otherwise)};
  }

  void fix(const Element& of) {
    for (const int port : of.ports)
      if (port >= 0 && setup_.type->inputs[index(port)].fixed) recipe_.needed[index(port)] = true;
  }

  void build_bodies() {
    number_.assign(layout_.elements.size(), -1);
    for (std::size_t i = 0; i < layout_.elements.size(); ++i) {
      const auto& one = layout_.elements[i];
      if (one.type->part != WorldPart::Body) continue;
      recipe_.by_number.push_back(used_.kept[i] ? static_cast<int>(recipe_.bodies.size()) : -1);
      if (!used_.kept[i]) continue;
      number_[i] = static_cast<int>(recipe_.bodies.size());
      fix(one);
      auto& body = recipe_.bodies.emplace_back();
      auto& model = recipe_.model.bodies.emplace_back();
      body.shape = model.shape = one.type->shape;
      model.friction = number(one, "friction");
      model.restitution = number(one, "restitution");
      model.collides = one.collides();
      model.moves = one.moves();
      if (model.shape == WorldShape::Plane) {
        model.normal = *one.vector("normal");
        model.offset = number(one, "offset");
        body.present.value = 1;
        add_look(one, model);
        continue;
      }
      model.turn = one.vector("turn").value_or(Vector3{});
      build_moving(one, body, model);
      add_look(one, model);
    }
  }

  void add_look(const Element& one, const BodyModel& model) {
    recipe_.looks.bodies.push_back({one.name, one.type->name, static_cast<int>(recipe_.by_number.size()),
                                    model.moves, model.normal, model.offset});
  }

  void build_moving(const Element& one, WorldBodyInputs& body, BodyModel& model) {
    static constexpr const char* kSizes[][3] = {
        {"radius", "", ""}, {"width", "depth", "height"}, {"radius", "length", ""}};
    static constexpr const char *kPlace[] = {"x", "y", "z"}, *kVelocity[] = {"vx", "vy", "vz"},
                                *kForce[] = {"fx", "fy", "fz"};
    auto& initial = model.initial;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      body.place[axis] = input(one, kPlace[axis]);
      body.velocity[axis] = input(one, kVelocity[axis]);
      body.force[axis] = input(one, kForce[axis]);
      body.size[axis] = input(one, kSizes[static_cast<int>(body.shape)][axis], kUnknownSize_m);
      initial.position[axis] = body.place[axis].value;
      initial.velocity[axis] = body.velocity[axis].value;
      initial.size[axis] = body.size[axis].value;
    }
    body.by_density = one.port("density") >= 0;
    body.mass = input(one, "mass", kUnknownMass_kg);
    body.density = input(one, "density");
    initial.mass = body.by_density && body.density.value > 0 ? body.density.value * body.volume(initial.size)
                   : body.by_density                         ? kUnknownMass_kg
                                                             : body.mass.value;
    body.put = input(one, "place");
    body.launch = input(one, "launch");
    body.present = input(one, "present", 1);
    model.present = body.present.value >= 0.5;
  }

  void build(std::size_t i) {
    const auto& one = layout_.elements[i];
    fix(one);
    const int on = one.ends[0] >= 0 ? number_[index(one.ends[0])] : -1;
    const int against = one.ends[1] >= 0 ? number_[index(one.ends[1])] : -1;
    switch (one.type->part) {
      case WorldPart::Joint:
        return build_joint(i, one, on, against);
      case WorldPart::Link:
        return build_link(one);
      case WorldPart::Handle:
        return build_handle(i, one, on);
      case WorldPart::Collision:
        number_[i] = static_cast<int>(recipe_.impacts.size());
        recipe_.impacts.push_back({on, against, number(one, "least_speed")});
        return;
      case WorldPart::Gravity:
        recipe_.gravity = {input(one, "x"), input(one, "y"), input(one, "z")};
        return;
      case WorldPart::Body:
        return;
    }
  }

  void build_joint(std::size_t i, const Element& one, int on, int against) {
    number_[i] = static_cast<int>(recipe_.model.joints.size());
    auto& joint = recipe_.model.joints.emplace_back();
    joint.kind = one.type->joint;
    joint.on = on;
    joint.against = against >= 0 && recipe_.model.bodies[index(against)].moves ? against : -1;
    joint.anchor = {number(one, "x"), number(one, "y"), number(one, "z")};
    joint.axis = one.vector("axis").value_or(joint.axis);
    joint.low = number(one, "low", joint.low);
    joint.high = number(one, "high", joint.high);
    for (const char* effort : {"torque", "force"})
      if (one.port(effort) >= 0) recipe_.drives.push_back({number_[i], input(one, effort)});
  }

  std::array<WorldInput, 3> inputs(const Element& of, const std::array<const char*, 3>& fields) {
    return {input(of, fields[0]), input(of, fields[1]), input(of, fields[2])};
  }

  void build_link(const Element& one) {
    auto& link = recipe_.links.emplace_back();
    link.joint = static_cast<int>(recipe_.model.joints.size()) + recipe_.model.links++;
    link.kind = input(one, "kind");
    link.first = input(one, "first");
    link.second = input(one, "second");
    link.anchor = inputs(one, {"x", "y", "z"});
    link.axis = inputs(one, {"ax", "ay", "az"});
    link.second_axis = inputs(one, {"bx", "by", "bz"});
    link.attach = input(one, "attach");
    link.stiffness = input(one, "stiffness");
    link.damping = input(one, "damping");
    link.effort = input(one, "effort");
    link.second_effort = input(one, "effort2");
  }

  void build_handle(std::size_t i, const Element& one, int on) {
    number_[i] = static_cast<int>(recipe_.handles.size());
    auto& handle = recipe_.handles.emplace_back();
    handle.body = on;
    handle.position = {input(one, "x"), input(one, "y"), input(one, "z")};
    for (std::size_t axis = 0; axis < 3; ++axis) handle.given[axis] = handle.position[axis].port >= 0;
    handle.stiffness = number(one, "stiffness");
    handle.damping = number(one, "damping");
    handle.passivity = number(one, "passivity");
    handle.holds = input(one, "holds");
    recipe_.looks.handles.push_back(one.name);
  }

  void build_outputs() {
    for (std::size_t i = 0; i < layout_.elements.size(); ++i) {
      const auto& one = layout_.elements[i];
      const auto& quantities = one.type->quantities;
      for (std::size_t q = 0; q < quantities.size(); ++q)
        recipe_.outputs.push_back({one.type, number_[i], static_cast<int>(q), quantities[q].reading});
      if (!quantities.empty()) recipe_.outputs.push_back({one.type, number_[i], 0, quantities[0].reading});
    }
    const auto own = world_quantities();
    for (std::size_t q = 0; q < own.size(); ++q)
      recipe_.outputs.push_back({nullptr, 0, static_cast<int>(q), own[q].reading});
  }

  void set_options() {
    const double rate = setup_.sample_rate.value;
    auto& model = recipe_.model;
    recipe_.frames = std::max(1, static_cast<int>(std::lround(rate / layout_.rate_hz)));
    const double h = recipe_.frames / rate;
    model.step_s = h;
    model.direct = layout_.direct;
    model.iterations = layout_.iterations;
    model.most_contacts =
        layout_.contacts > 0 ? layout_.contacts : 6 * static_cast<int>(model.bodies.size()) + 16;
    model.erp = layout_.erp;
    model.cfm = layout_.cfm;
    if (layout_.stiffness) {
      const double give = h * *layout_.stiffness + layout_.damping.value_or(0);
      model.erp = h * *layout_.stiffness / give;
      model.cfm = 1 / give;
    }
    model.bounce_speed = layout_.bounce_speed;
    model.correction_speed = layout_.correction_speed.value_or(model.correction_speed);
  }

  void report_left_out() {
    Fingerprint print;
    for (std::size_t i = 0; i < used_.kept.size(); ++i) {
      print.add(std::uint64_t{used_.kept[i]});
      if (used_.kept[i]) continue;
      recipe_.left_out.push_back(
          {layout_.elements[i].name, used_.absent[i] ? "is never present" : "reaches no output"});
    }
    if (!recipe_.left_out.empty()) recipe_.variant = print.value();
  }

  const WorldLayout& layout_;
  const NodeSetup& setup_;
  WorldRecipe recipe_;
  WorldUse used_;
  std::vector<int> number_;  ///< of elements: the part that they have become
};

}  // namespace

double WorldBodyInputs::volume(const std::array<double, 3>& s) const {
  constexpr double pi = std::numbers::pi;
  switch (shape) {
    case WorldShape::Sphere:
      return 4.0 / 3.0 * pi * s[0] * s[0] * s[0];
    case WorldShape::Box:
      return s[0] * s[1] * s[2];
    case WorldShape::Capsule:
      return pi * s[0] * s[0] * (s[1] + 4.0 / 3.0 * s[0]);
    case WorldShape::Plane:
      return 0;
  }
  return 0;
}

WorldRecipe build_world(const WorldLayout& layout, const NodeSetup& setup) {
  return WorldBuilder(layout, setup).run();
}

}  // namespace tactus
