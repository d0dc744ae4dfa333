#include "remote/osc/osc_joints.h"

#include <algorithm>
#include <array>

namespace tactus {
namespace {

constexpr std::string_view kKind = "_kind";
constexpr std::array kAnchor = {"_x", "_y", "_z"}, kAxis = {"_ax", "_ay", "_az"},
                     kSecondAxis = {"_bx", "_by", "_bz"};

/// What is said of each kind, three numbers each, in this order.
struct JointMessage {
  std::string_view message, joint;  ///< `joint`: in kJointNames
  bool anchor;
  int axes;
};
constexpr std::array kJoints = {
    JointMessage{"fixed", "fixed", false, 0},        JointMessage{"ball", "ball", true, 0},
    JointMessage{"hinge", "hinge", true, 1},         JointMessage{"hinge2", "hinge2", true, 2},
    JointMessage{"universal", "universal", true, 2}, JointMessage{"slide", "slider", false, 1},
    JointMessage{"piston", "piston", true, 1}};

/// What a joint is asked for, and the controls that take its numbers.
struct Response {
  std::string_view message;
  std::vector<const char*> controls;
};
const std::array kResponses = {
    Response{"response/spring", {"_stiffness", "_damping"}},
    Response{"response/torque", {"_effort"}},
    Response{"response/force", {"_effort"}},
    Response{"response/torque1", {"_effort"}},
    Response{"response/torque2", {"_effort2"}},
};

}  // namespace

bool OscJoints::is_kind(std::string_view kind) {
  return std::ranges::find(kJoints, kind, &JointMessage::message) != kJoints.end();
}

Status OscJoints::create(std::string_view kind, const OscMessage& message, const FindObject& find_object,
                         OscOrders& orders) {
  const auto& known = *std::ranges::find(kJoints, kind, &JointMessage::message);
  const auto *name = text_at(message, 0), *first = text_at(message, 1), *second = text_at(message, 2);
  const auto numbers = numbers_of(message, 3);
  const auto needed = static_cast<std::size_t>(3 * (known.anchor ? 1 : 0) + 3 * known.axes);
  if (name == nullptr || first == nullptr || second == nullptr || !numbers || numbers->size() != needed)
    return world_error(Errc::BadArgument, message.address + " takes a name, two objects and " +
                                              std::to_string(needed) + " numbers");
  if (exists(*name))
    return world_error(Errc::Duplicate, "there is a joint '" + *name + "' already", "destroy it first");
  for (int axis = 0; axis < known.axes; ++axis) {
    const double* const at = numbers->data() + (known.anchor ? 3 : 0) + 3 * axis;
    if (at[0] == 0 && at[1] == 0 && at[2] == 0)
      return world_error(Errc::OutOfRange, "an axis of '" + *name + "' has no direction",
                         "give a vector that is not 0, as in 0 0 1");
  }
  const auto one = find_object(*first);
  const auto other = *second == "world" ? OscObject{} : find_object(*second);
  for (const auto& [text, object] : {std::pair{first, &one}, std::pair{second, &other}})
    if (object->number == 0 && *text != "world")
      return world_error(Errc::UnknownName, "there is no object '" + *text + "' that can be joined");
  if (one.number == 0 || one.number == other.number || (other.number != 0 && one.world != other.world))
    return world_error(Errc::BadArgument,
                       "a joint takes two different objects of one world, or one and 'world'");
  const auto& description = orders.description();
  const auto beginning = description.worlds[static_cast<std::size_t>(one.world)].name + "_";
  for (const auto& control : description.controls) {
    if (!control.name.starts_with(beginning) || !control.name.ends_with(kKind)) continue;
    const auto link = control.name.substr(0, control.name.size() - kKind.size());
    const bool taken =
        std::ranges::any_of(links_, [&](const auto& entry) { return entry.second.controls == link; });
    if (taken || orders.find(link + "_attach") == nullptr ||
        control.value.load(std::memory_order_relaxed) >= 0.5)
      continue;
    links_[*name] = {link, one.controls, other.controls};
    auto next = numbers->begin();
    const auto take = [&](const auto& controls) {
      for (const auto* axis : controls) orders.set(link + axis, *next++);
    };
    if (known.anchor) take(kAnchor);
    if (known.axes > 0) take(kAxis);
    if (known.axes > 1) take(kSecondAxis);
    for (const auto& response : kResponses)
      for (const auto* part : response.controls)
        if (response.message != "response/force" && response.message != "response/torque1")
          orders.set(link + part, 0);
    const auto number = std::ranges::find(kJointNames, known.joint) - kJointNames.begin() + 1;
    orders.set(control.name, static_cast<double>(number));
    orders.set(link + "_first", one.number);
    orders.set(link + "_second", other.number);
    orders.pull(link + "_attach");
    return {};
  }
  return world_error(Errc::OutOfRange, "no link is free",
                     "give the world more of them: link_1 = { type = \"link\", remote = \"yes\" }");
}

Status OscJoints::change(const std::string& name, std::string_view what, const OscMessage& message,
                         OscOrders& orders) {
  const auto link = links_.find(name);
  if (what == "destroy") {
    remove(link->second, orders);
    links_.erase(link);
    return {};
  }
  const auto* known = std::ranges::find(kResponses, what, &Response::message);
  if (known == kResponses.end())
    return world_error(Errc::UnknownName, "there is no message " + message.address,
                       "a joint takes response/spring, response/torque, response/torque1, response/torque2, "
                       "response/force and destroy");
  const auto numbers = numbers_of(message, 0);
  if (!numbers || numbers->size() != known->controls.size())
    return world_error(Errc::BadArgument, message.address + " takes " +
                                              (known->controls.size() == 1 ? "one number" : "two numbers"));
  for (std::size_t i = 0; i < numbers->size(); ++i)
    orders.set(link->second.controls + known->controls[i], (*numbers)[i]);
  return {};
}

std::vector<std::string> OscJoints::controls_of(const std::string& name, std::string_view what) const {
  const auto link = links_.find(name);
  const auto* known = std::ranges::find(kResponses, what, &Response::message);
  std::vector<std::string> names;
  if (link == links_.end() || known == kResponses.end()) return names;
  for (const auto* part : known->controls) names.push_back(link->second.controls + part);
  return names;
}

void OscJoints::destroy_of(const std::string& body, OscOrders& orders) {
  std::erase_if(links_, [&](const auto& entry) {
    const auto& link = entry.second;
    if (!body.empty() && link.one != body && link.other != body) return false;
    remove(link, orders);
    return true;
  });
}

void OscJoints::remove(const Link& link, OscOrders& orders) {
  orders.set(link.controls + std::string{kKind}, 0);
  orders.pull(link.controls + "_attach");
}

}  // namespace tactus
