#include "remote/osc/osc_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tactus {
namespace {

constexpr std::string_view kPresent = "_present";
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

const RemoteControl* find_control(const RemoteDescription& description, const std::string& name) {
  const int at = description.find_control(name);
  return at < 0 ? nullptr : &description.controls[static_cast<std::size_t>(at)];
}

std::vector<double> numbers_of(const OscMessage& message, std::size_t first) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < message.values.size(); ++i) {
    const auto* real = std::get_if<double>(&message.values[i]);
    const auto* whole = std::get_if<std::int64_t>(&message.values[i]);
    if (real == nullptr && whole == nullptr) return {};
    numbers.push_back(real != nullptr ? *real : static_cast<double>(*whole));
    if (!std::isfinite(numbers.back())) return {};
  }
  return numbers;
}

void set(const RemoteDescription& description, const std::string& control, double value,
         std::vector<RemoteOrder>& orders) {
  if (const auto* found = find_control(description, control))
    orders.push_back(
        {.number = found->number, .value = std::clamp(value, found->low, found->high), .received = {}});
}

void pull(const RemoteDescription& description, const std::string& control,
          std::vector<RemoteOrder>& orders) {
  if (const auto* found = find_control(description, control))
    orders.push_back({.kind = RemoteOrder::Kind::Trigger, .number = found->number, .received = {}});
}

/// The beginning of the names of a body's controls; "": this is no control that only a body has.
std::string body_with(const RemoteControl& control) {
  return control.name.ends_with(kPresent) ? control.name.substr(0, control.name.size() - kPresent.size())
                                          : "";
}

auto failure(Errc code, std::string what, std::string remedy = {}) {
  return tl::unexpected(Error{code, "", std::move(what), std::move(remedy)});
}

}  // namespace

bool OscWorld::has_bodies(const RemoteDescription& description) {
  return std::ranges::any_of(description.controls, [&](const RemoteControl& control) {
    const auto body = body_with(control);
    return !body.empty() && find_control(description, body + "_place") != nullptr;
  });
}

Status OscWorld::obey(const OscMessage& message, const RemoteDescription& description,
                      std::vector<RemoteOrder>& orders) {
  const auto path = std::string_view{message.address}.substr(kBeginning.size());
  if (path == "clear") {
    for (const auto& [object, body] : created_) set(description, body + std::string{kPresent}, 0, orders);
    created_.clear();
    return {};
  }
  if (path == "gravity") {
    const auto gravity = std::ranges::find_if(
        description.controls, [](const auto& control) { return control.name.ends_with("_gravity_x"); });
    const auto numbers = numbers_of(message, 0);
    if (gravity == description.controls.end())
      return failure(Errc::UnknownName, "gravity cannot be changed",
                     "give the world an element gravity with remote = \"yes\"");
    if (numbers.size() != 3) return failure(Errc::BadArgument, "gravity takes three numbers, in m/s^2");
    const auto name = gravity->name.substr(0, gravity->name.size() - 1);
    for (std::size_t axis = 0; axis < 3; ++axis) set(description, name + "xyz"[axis], numbers[axis], orders);
    return {};
  }
  const auto slash = path.find('/');
  const auto first = path.substr(0, slash), rest = slash == path.npos ? "" : path.substr(slash + 1);
  if (rest == "create") return create(first, message, description, orders);
  return change(std::string{first}, rest, message, description, orders);
}

/// The name that a message created, or that of a body in the graph file which is present.
std::string OscWorld::body_of(const std::string& object, const RemoteDescription& description) const {
  if (const auto found = created_.find(object); found != created_.end()) return found->second;
  for (const auto& control : description.controls)
    if (const auto body = body_with(control); body.ends_with("_" + object)) {
      const bool taken =
          std::ranges::any_of(created_, [&](const auto& entry) { return entry.second == body; });
      if (!taken && control.value.load(std::memory_order_relaxed) >= 0.5) return body;
    }
  return "";
}

Status OscWorld::create(std::string_view shape, const OscMessage& message,
                        const RemoteDescription& description, std::vector<RemoteOrder>& orders) {
  const auto* known = std::ranges::find(kShapes, shape, &Shape::message);
  if (known == kShapes.end())
    return failure(Errc::UnknownName, "a " + std::string{shape} + " cannot be created while the world runs",
                   "write it in the graph file");
  const auto* name = message.values.empty() ? nullptr : std::get_if<std::string>(&message.values[0]);
  if (name == nullptr || name->empty() || name->size() > kLongestName || name->find('/') != name->npos)
    return failure(Errc::BadArgument, message.address + " takes a name and a position");
  auto place = numbers_of(message, 1);
  if (message.values.size() == 1) place = {0, 0, 0};
  if (place.size() != 3) return failure(Errc::BadArgument, "a position is three numbers, in m");
  if (!body_of(*name, description).empty())
    return failure(Errc::Duplicate, "there is an object '" + *name + "' already", "destroy it first");
  for (const auto& control : description.controls) {
    const auto body = body_with(control);
    const bool fits = !body.empty() && find_control(description, body + "_place") != nullptr &&
                      find_control(description, body + known->has) != nullptr &&
                      find_control(description, body + known->lacks) == nullptr;
    const bool taken = std::ranges::any_of(created_, [&](const auto& entry) { return entry.second == body; });
    if (!fits || taken || control.value.load(std::memory_order_relaxed) >= 0.5) continue;
    created_[*name] = body;
    for (const auto& change : kChanges)
      if (change.controls.size() == 3 && change.message != "size")
        for (std::size_t axis = 0; axis < 3; ++axis)
          set(description, body + change.controls[axis], change.message == "position" ? place[axis] : 0.0,
              orders);
    set(description, control.name, 1, orders);
    pull(description, body + "_place", orders);
    pull(description, body + "_launch", orders);
    return {};
  }
  return failure(Errc::OutOfRange, "no " + std::string{shape} + " is free",
                 "give the world more of them with remote = \"yes\" and present = 0");
}

Status OscWorld::change(const std::string& object, std::string_view what, const OscMessage& message,
                        const RemoteDescription& description, std::vector<RemoteOrder>& orders) {
  const auto body = body_of(object, description);
  if (body.empty()) return failure(Errc::UnknownName, "there is no object '" + object + "'");
  if (what == "destroy") {
    set(description, body + std::string{kPresent}, 0, orders);
    created_.erase(object);
    return {};
  }
  const auto* known = std::ranges::find(kChanges, what, &Change::message);
  if (known == kChanges.end())
    return failure(Errc::UnknownName, "there is no message " + message.address,
                   "an object takes position, velocity, force, mass, density, radius, size and destroy");
  const auto numbers = numbers_of(message, 0);
  if (numbers.size() != known->controls.size())
    return failure(Errc::BadArgument, message.address + " takes " + std::to_string(known->controls.size()) +
                                          (known->controls.size() == 1 ? " number" : " numbers"));
  for (const auto* control : known->controls)
    if (find_control(description, body + control) == nullptr)
      return failure(Errc::UnknownName,
                     "'" + object + "' has no " + std::string{what} + " that can be changed");
  for (std::size_t i = 0; i < numbers.size(); ++i)
    set(description, body + known->controls[i], numbers[i], orders);
  if (*known->trigger != '\0') pull(description, body + known->trigger, orders);
  return {};
}

}  // namespace tactus
