#include "remote/osc/osc_world_values.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus {
namespace {

constexpr std::string_view kGet = "/get", kCollide = "collide";

using Numbers = std::vector<double>;

Numbers list_of(const std::array<double, 3>& vector) { return {vector.begin(), vector.end()}; }

/// Row after row.
Numbers rotation_of(const BodyPose& pose) {
  const auto [w, x, y, z] = pose.turn;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

/// What is known of a body after a step.
struct BodyValue {
  std::string_view name;
  Numbers (*read)(const BodyPose&);
};
constexpr std::array kBodyValues = {
    BodyValue{"position", [](const BodyPose& pose) { return list_of(pose.position); }},
    BodyValue{"velocity", [](const BodyPose& pose) { return list_of(pose.velocity); }},
    BodyValue{"acceleration", [](const BodyPose& pose) { return list_of(pose.acceleration); }},
    BodyValue{"rotation", rotation_of},
    BodyValue{"radius", [](const BodyPose& pose) { return Numbers{pose.size[0]}; }},
    BodyValue{"size", [](const BodyPose& pose) { return list_of(pose.size); }}};
struct CursorValue {
  std::string_view name;
  std::array<double, 3> HandlePose::*now;
};
constexpr std::array kCursorValues = {CursorValue{"position", &HandlePose::position},
                                      CursorValue{"force", &HandlePose::force}};

/// Nothing: it is not known now.
std::optional<Numbers> value_of(const std::string& name, const std::string& value, const OscWorld& world,
                                const RemoteDescription& description, const RemoteBodies* bodies) {
  if (name == OscWorld::kCursor) {
    const auto* known = std::ranges::find(kCursorValues, value, &CursorValue::name);
    if (bodies == nullptr || known == kCursorValues.end()) return std::nullopt;
    for (const auto& one : bodies->worlds)
      if (!one.handles.empty()) return list_of(one.handles.front().*known->now);
    return std::nullopt;
  }
  const auto* known = std::ranges::find(kBodyValues, value, &BodyValue::name);
  if (known != kBodyValues.end()) {
    const auto* pose = pose_of(bodies, world.find(name, description));
    return pose != nullptr ? std::optional{known->read(*pose)} : std::nullopt;
  }
  Numbers numbers;
  for (const auto& control : world.controls_of(name, value, description)) {
    const int at = description.find_control(control);
    if (at < 0) return std::nullopt;
    numbers.push_back(
        description.controls[static_cast<std::size_t>(at)].value.load(std::memory_order_relaxed));
  }
  return numbers.empty() ? std::nullopt : std::optional{numbers};
}

bool can_be_read(const std::string& name, const std::string& value, const OscWorld& world,
                 const RemoteDescription& description) {
  if (name == OscWorld::kCursor)
    return std::ranges::find(kCursorValues, value, &CursorValue::name) != kCursorValues.end() &&
           std::ranges::any_of(description.worlds,
                               [](const auto& one) { return !one.looks.handles.empty(); });
  if (!world.controls_of(name, value, description).empty()) return true;
  return std::ranges::find(kBodyValues, value, &BodyValue::name) != kBodyValues.end() &&
         world.find(name, description).body >= 0;
}

}  // namespace

bool OscWorldValues::is_question(std::string_view address) {
  return address.ends_with(kGet) || address.ends_with(std::string{"/"} + std::string{kCollide});
}

Status OscWorldValues::ask(const OscPeer& peer, const OscMessage& message, const OscWorld& world,
                           const RemoteDescription& description, Clock::time_point now) {
  return message.address.ends_with(kGet) ? ask_value(peer, message, world, description, now)
                                         : ask_collisions(peer, message, world, description);
}

Status OscWorldValues::ask_value(const OscPeer& peer, const OscMessage& message, const OscWorld& world,
                                 const RemoteDescription& description, Clock::time_point now) {
  auto path = std::string_view{message.address}.substr(OscWorld::kBeginning.size());
  path.remove_suffix(kGet.size());
  Get get;
  get.magnitude = path.ends_with(OscWorld::kMagnitude);
  if (get.magnitude) path.remove_suffix(OscWorld::kMagnitude.size());
  const auto slash = path.find('/');
  if (slash == path.npos) {
    get.value = path;  // "/world/gravity/get"
  } else {
    get.object = path.substr(0, slash);
    get.value = path.substr(slash + 1);
  }
  if (!can_be_read(get.object, get.value, world, description))
    return world_error(
        Errc::UnknownName, "there is nothing to get at " + message.address,
        "position, velocity, acceleration, rotation, radius and size of a body, and force, mass "
        "and density where it has controls for them");
  const auto numbers = tactus::numbers_of(message, 0);
  if (!numbers || numbers->size() > 1 ||
      (numbers->size() == 1 && !(numbers->front() >= 0 && numbers->front() <= 1e6)))
    return world_error(Errc::BadArgument, message.address + " takes an interval in ms, or nothing");
  auto& gets = clients_[peer].gets;
  std::erase_if(gets, [&](const Get& other) {
    return other.object == get.object && other.value == get.value && other.magnitude == get.magnitude &&
           (other.interval.count() > 0) == !numbers->empty();
  });
  if (!numbers->empty() && numbers->front() == 0) return {};  // no more
  if (gets.size() >= kMostGets)
    return world_error(Errc::OutOfRange, "too many values are asked for",
                       "end some of them with the interval 0");
  if (!numbers->empty())
    get.interval = std::max<Clock::duration>(
        kLeastInterval, std::chrono::duration_cast<Clock::duration>(
                            std::chrono::duration<double, std::milli>{numbers->front()}));
  get.asked = now;
  get.next = numbers->empty() ? now + kSettled : now;
  gets.push_back(std::move(get));
  return {};
}

Status OscWorldValues::ask_collisions(const OscPeer& peer, const OscMessage& message, const OscWorld& world,
                                      const RemoteDescription& description) {
  auto path = std::string_view{message.address}.substr(OscWorld::kBeginning.size());
  path.remove_suffix(std::min(path.size(), kCollide.size() + 1));
  const auto numbers = tactus::numbers_of(message, 0);
  if (!numbers || numbers->size() != 1)
    return world_error(Errc::BadArgument, message.address + " takes 1 or 0");
  auto& client = clients_[peer];
  const bool on = numbers->front() != 0;
  if (path.empty()) {
    client.all_collisions = on;
    return {};
  }
  const std::string name{path};
  if (world.find(name, description).body < 0)
    return world_error(Errc::UnknownName, "there is no object '" + name + "'");
  if (on && client.collisions.size() < kMostGets) client.collisions.insert(name);
  if (!on) client.collisions.erase(name);
  return {};
}

void OscWorldValues::forget(const OscPeer& peer) { clients_.erase(peer); }

RemoteWatch OscWorldValues::wanted(Clock::time_point now) const {
  RemoteWatch watch;
  watch.poses = now < watch_until_;
  for (const auto& [peer, client] : clients_) {
    watch.poses |= !client.gets.empty();
    watch.impacts |= client.all_collisions || !client.collisions.empty();
  }
  return watch;
}

void OscWorldValues::tick(const OscWorld& world, const RemoteDescription& description,
                          const RemoteBodies* bodies, Clock::time_point now, const Send& send) {
  for (auto& [peer, client] : clients_) {
    for (auto& get : client.gets) {
      if (now < get.next) continue;
      const auto numbers = value_of(get.object, get.value, world, description, bodies);
      if (!numbers) continue;
      get.next = get.interval.count() > 0 ? std::max(get.next + get.interval, now) : Clock::time_point::max();
      OscMessage answer{std::string{OscWorld::kBeginning} + get.object + (get.object.empty() ? "" : "/") +
                        get.value};
      if (get.magnitude) {
        answer.address += OscWorld::kMagnitude;
        double squares = 0;
        for (const double number : *numbers) squares += number * number;
        answer.values.emplace_back(std::sqrt(squares));
      } else {
        for (const double number : *numbers) answer.values.emplace_back(number);
      }
      send(peer, std::move(answer));
    }
    std::erase_if(client.gets, [&](const Get& get) {
      return get.next == Clock::time_point::max() ||
             (get.interval.count() == 0 && now - get.asked > kPatience);
    });
  }
}

void OscWorldValues::impact(const RemoteEvent& event, const OscWorld& world,
                            const RemoteDescription& description, const Send& send) const {
  const auto one = world.name_of(event.value, event.bodies[0], description);
  const auto other = world.name_of(event.value, event.bodies[1], description);
  if (one.empty() || other.empty()) return;
  const std::string beginning{OscWorld::kBeginning};
  for (const auto& [peer, client] : clients_) {
    if (client.all_collisions) send(peer, {beginning + std::string{kCollide}, {one, other, event.level}});
    for (const auto& [name, with] : {std::pair{one, other}, std::pair{other, one}})
      if (client.collisions.contains(name))
        send(peer, {beginning + name + "/" + std::string{kCollide}, {with, event.level}});
  }
}

}  // namespace tactus
