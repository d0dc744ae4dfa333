#include "remote/osc/osc_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tactus {
namespace {

constexpr std::string_view kPresent = "_present", kHolds = "_holds";
constexpr std::size_t kLongestName = 64;

/// What an object is asked for: the controls that take its numbers, and the trigger that makes them act.
struct Change {
  std::string_view message;
  std::vector<const char*> controls;
  const char* trigger = "";
};
const std::array kChanges = {Change{"position", {"_x", "_y", "_z"}, "_place"},
                             Change{"velocity", {"_vx", "_vy", "_vz"}, "_launch"},
                             Change{"force", {"_fx", "_fy", "_fz"}},
                             Change{"mass", {"_mass"}},
                             Change{"density", {"_density"}},
                             Change{"radius", {"_radius"}},
                             Change{"size", {"_width", "_depth", "_height"}}};

/// What a body of each shape has a control for, and has not.
struct Shape {
  std::string_view message;
  const char *has, *lacks;
};
constexpr std::array kShapes = {Shape{"sphere", "_radius", "_length"}, Shape{"prism", "_width", "_length"}};

/// What has a magnitude, and where its direction is known from; nullptr: from its controls.
struct Direction {
  std::string_view message;
  std::array<double, 3> BodyPose::*now;
};
constexpr std::array kDirections = {Direction{"position", &BodyPose::position},
                                    Direction{"velocity", &BodyPose::velocity}, Direction{"force", nullptr}};

/// The beginning of the names of a body's controls; "": this is no control that only a body has.
std::string body_with(const RemoteControl& control) {
  return control.name.ends_with(kPresent) ? control.name.substr(0, control.name.size() - kPresent.size())
                                          : "";
}

double value_now(const RemoteControl& control) { return control.value.load(std::memory_order_relaxed); }

/// The beginning of the names of a world's gravity; "": there is none.
std::string gravity_of(const RemoteDescription& description) {
  const auto gravity = std::ranges::find_if(
      description.controls, [](const auto& control) { return control.name.ends_with("_gravity_x"); });
  return gravity == description.controls.end() ? "" : gravity->name.substr(0, gravity->name.size() - 2);
}

}  // namespace

bool OscWorld::has_bodies(const RemoteDescription& description) {
  return std::ranges::any_of(description.controls, [&](const RemoteControl& control) {
    const auto body = body_with(control);
    return !body.empty() && description.find_control(body + "_place") >= 0;
  });
}

Status OscWorld::obey(const OscMessage& message, const RemoteDescription& description,
                      const RemoteBodies* bodies, std::vector<RemoteOrder>& orders) {
  OscOrders out{description, orders};
  const auto path = std::string_view{message.address}.substr(kBeginning.size());
  if (path == "clear") return clear(out), Status{};
  if (path == "drop") return grab("", out);
  if (path == "gravity") {
    const auto name = gravity_of(description);
    const auto numbers = numbers_of(message, 0);
    if (name.empty())
      return world_error(Errc::UnknownName, "gravity cannot be changed",
                         "give the world an element gravity with remote = \"yes\"");
    if (!numbers || numbers->size() != 3)
      return world_error(Errc::BadArgument, "gravity takes three numbers, in m/s^2");
    for (std::size_t axis = 0; axis < 3; ++axis) out.set(name + "_" + "xyz"[axis], (*numbers)[axis]);
    return {};
  }
  const auto slash = path.find('/');
  const std::string first{path.substr(0, slash)};
  const auto rest = slash == path.npos ? "" : path.substr(slash + 1);
  if (rest == "create" && OscJoints::is_kind(first)) {
    const auto* name = text_at(message, 0);
    if (name != nullptr && !find(*name, description).controls.empty())
      return world_error(Errc::Duplicate, "there is an object '" + *name + "' already",
                         "choose another name");
    return joints_.create(
        first, message, [&](const auto& object) { return find(object, description); }, out);
  }
  if (rest == "create") return create(first, message, out);
  if (joints_.exists(first)) return joints_.change(first, rest, message, out);
  return change(first, rest, message, bodies, out);
}

void OscWorld::clear(OscOrders& orders) {
  joints_.destroy_of("", orders);
  for (const auto& [object, body] : created_) orders.set(body + std::string{kPresent}, 0);
  created_.clear();
}

/// The controls of an object that a message created, or of a body in the graph file which is present.
std::string OscWorld::present_body(const std::string& name, const RemoteDescription& description) const {
  if (const auto found = created_.find(name); found != created_.end()) return found->second;
  for (const auto& control : description.controls)
    if (const auto body = body_with(control); body.ends_with("_" + name)) {
      const bool taken =
          std::ranges::any_of(created_, [&](const auto& entry) { return entry.second == body; });
      if (!taken && value_now(control) >= 0.5) return body;
    }
  return "";
}

OscObject OscWorld::find(const std::string& name, const RemoteDescription& description) const {
  OscObject object{.controls = present_body(name, description)};
  for (std::size_t w = 0; w < description.worlds.size(); ++w) {
    const auto& world = description.worlds[w];
    for (std::size_t b = 0; b < world.looks.bodies.size(); ++b) {
      const auto& look = world.looks.bodies[b];
      const auto controls = world.name + "_" + look.name;
      // One without controls is known by its name in the file.
      const bool remote = description.find_control(controls + std::string{kPresent}) >= 0;
      if (object.controls.empty() ? remote || look.name != name : controls != object.controls) continue;
      object.world = static_cast<int>(w);
      object.body = static_cast<int>(b);
      object.number = look.number;
      return object;
    }
  }
  return object;
}

std::string OscWorld::name_of(int world, int body, const RemoteDescription& description) const {
  if (world < 0 || world >= std::ssize(description.worlds)) return "";
  const auto& in = description.worlds[static_cast<std::size_t>(world)];
  if (body < 0 || body >= std::ssize(in.looks.bodies)) return "";
  const auto& look = in.looks.bodies[static_cast<std::size_t>(body)].name;
  const auto created =
      std::ranges::find_if(created_, [&](const auto& entry) { return entry.second == in.name + "_" + look; });
  return created != created_.end() ? created->first : look;
}

std::vector<std::string> OscWorld::controls_of(const std::string& name, std::string_view value,
                                               const RemoteDescription& description) const {
  std::vector<std::string> names;
  if (name.empty()) {
    const auto gravity = gravity_of(description);
    if (value == "gravity" && !gravity.empty()) names = {gravity + "_x", gravity + "_y", gravity + "_z"};
    return names;
  }
  if (joints_.exists(name)) return joints_.controls_of(name, value);
  const auto body = present_body(name, description);
  const auto* known = std::ranges::find(kChanges, value, &Change::message);
  // Places and velocities are those that it was given, not those that it has.
  if (body.empty() || known == kChanges.end() || *known->trigger != '\0') return names;
  for (const auto* part : known->controls) names.push_back(body + part);
  const bool all =
      std::ranges::all_of(names, [&](const auto& control) { return description.find_control(control) >= 0; });
  return all ? names : std::vector<std::string>{};
}

Status OscWorld::create(std::string_view shape, const OscMessage& message, OscOrders& orders) {
  const auto& description = orders.description();
  const auto* known = std::ranges::find(kShapes, shape, &Shape::message);
  if (known == kShapes.end())
    return world_error(
        Errc::UnknownName,
        "a " + std::string{shape} + " cannot be created; worlds create spheres and prisms, and joints");
  const auto* name = text_at(message, 0);
  if (name == nullptr || name->empty() || name->size() > kLongestName || name->find('/') != name->npos)
    return world_error(Errc::BadArgument, message.address + " takes a name and a position");
  const auto place = message.values.size() == 1 ? std::vector<double>(3) : numbers_of(message, 1);
  if (!place || place->size() != 3)
    return world_error(Errc::BadArgument, "a position is three numbers, in m");
  if (!find(*name, description).controls.empty() || joints_.exists(*name))
    return world_error(Errc::Duplicate, "there is an object '" + *name + "' already", "destroy it first");
  for (const auto& control : description.controls) {
    const auto body = body_with(control);
    const bool fits = !body.empty() && orders.find(body + "_place") != nullptr &&
                      orders.find(body + known->has) != nullptr &&
                      orders.find(body + known->lacks) == nullptr;
    const bool taken = std::ranges::any_of(created_, [&](const auto& entry) { return entry.second == body; });
    if (!fits || taken || value_now(control) >= 0.5) continue;
    created_[*name] = body;
    for (const auto& change : kChanges)
      if (change.controls.size() == 3 && change.message != "size")
        for (std::size_t axis = 0; axis < 3; ++axis)
          orders.set(body + change.controls[axis], change.message == "position" ? (*place)[axis] : 0.0);
    orders.set(control.name, 1);
    orders.pull(body + "_place");
    orders.pull(body + "_launch");
    return {};
  }
  return world_error(Errc::OutOfRange, "no " + std::string{shape} + " is free",
                     "give the world more of them with remote = \"yes\" and present = 0");
}

Status OscWorld::change(const std::string& name, std::string_view what, const OscMessage& message,
                        const RemoteBodies* bodies, OscOrders& orders) {
  if (what == "grab") return grab(name, orders);
  const auto body = present_body(name, orders.description());
  if (body.empty()) return world_error(Errc::UnknownName, "there is no object '" + name + "'");
  if (what == "destroy") {
    joints_.destroy_of(body, orders);
    orders.set(body + std::string{kPresent}, 0);
    created_.erase(name);
    return {};
  }
  if (what.ends_with(kMagnitude))
    return set_magnitude(name, what.substr(0, what.size() - kMagnitude.size()), message, bodies, orders);
  const auto* known = std::ranges::find(kChanges, what, &Change::message);
  if (known == kChanges.end())
    return world_error(
        Errc::UnknownName, "there is no message " + message.address,
        "an object takes position, velocity, force, mass, density, radius, size, grab, collide "
        "and destroy");
  const auto numbers = numbers_of(message, 0);
  if (!numbers || numbers->size() != known->controls.size())
    return world_error(Errc::BadArgument, message.address + " takes " +
                                              std::to_string(known->controls.size()) +
                                              (known->controls.size() == 1 ? " number" : " numbers"));
  for (const auto* control : known->controls)
    if (orders.find(body + control) == nullptr)
      return world_error(Errc::UnknownName,
                         "'" + name + "' has no " + std::string{what} + " that can be changed");
  for (std::size_t i = 0; i < numbers->size(); ++i) orders.set(body + known->controls[i], (*numbers)[i]);
  if (*known->trigger != '\0') orders.pull(body + known->trigger);
  return {};
}

/// Keeps the direction: of a force that of its controls, of a place or velocity that which the body has.
Status OscWorld::set_magnitude(const std::string& name, std::string_view what, const OscMessage& message,
                               const RemoteBodies* bodies, OscOrders& orders) {
  const auto numbers = numbers_of(message, 0);
  if (!numbers || numbers->size() != 1)
    return world_error(Errc::BadArgument, message.address + " takes one number");
  const auto* known = std::ranges::find(kDirections, what, &Direction::message);
  if (known == kDirections.end())
    return world_error(Errc::UnknownName, "there is no message " + message.address,
                       "position, velocity and force have a magnitude");
  const auto object = find(name, orders.description());
  std::array<double, 3> vector{};
  if (known->now != nullptr) {
    const auto* pose = pose_of(bodies, object);
    if (pose == nullptr)
      return world_error(Errc::Missing, "the " + std::string{what} + " of '" + name + "' is not known yet",
                         "send it again in 50 ms");
    vector = pose->*known->now;
  } else {
    const auto controls = controls_of(name, what, orders.description());
    for (std::size_t axis = 0; axis < std::min(controls.size(), vector.size()); ++axis)
      vector[axis] = value_now(*orders.find(controls[axis]));
  }
  const double length = std::hypot(vector[0], vector[1], vector[2]);
  if (!(length > 0))
    return world_error(Errc::OutOfRange, "the " + std::string{what} + " of '" + name + "' has no direction",
                       "give its three numbers first");
  OscMessage whole{std::string{kBeginning} + name + "/" + std::string{what}};
  for (const double part : vector) whole.values.emplace_back(part * (numbers->front() / length));
  return change(name, what, whole, bodies, orders);
}

/// Handles of the object's world hold it; without a name all let go.
Status OscWorld::grab(const std::string& name, OscOrders& orders) {
  const auto& description = orders.description();
  const auto object = name.empty() ? OscObject{} : find(name, description);
  if (!name.empty() && object.number == 0)
    return world_error(Errc::UnknownName, "there is no object '" + name + "' that can be held");
  bool any = false;
  for (std::size_t w = 0; w < description.worlds.size(); ++w)
    for (const auto& handle : description.worlds[w].looks.handles) {
      const auto control = description.worlds[w].name + "_" + handle + std::string{kHolds};
      if (orders.find(control) == nullptr) continue;
      any |= name.empty() || object.world == static_cast<int>(w);
      // The object that was held before is dropped.
      orders.set(control, object.world == static_cast<int>(w) ? object.number : 0);
      if (!name.empty() && object.world == static_cast<int>(w)) return {};
    }
  return any ? Status{}
             : world_error(Errc::UnknownName, "no handle can hold it",
                           "give the world's handle remote = \"yes\"");
}

}  // namespace tactus
