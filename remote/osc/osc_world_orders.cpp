#include "remote/osc/osc_world_orders.h"

#include <algorithm>
#include <cmath>

namespace tactus {

const RemoteControl* OscOrders::find(const std::string& control) const {
  const int at = description_.find_control(control);
  return at < 0 ? nullptr : &description_.controls[static_cast<std::size_t>(at)];
}

void OscOrders::set(const std::string& control, double value) {
  if (const auto* found = find(control))
    orders_.push_back(
        {.number = found->number, .value = std::clamp(value, found->low, found->high), .received = {}});
}

void OscOrders::pull(const std::string& control) {
  if (const auto* found = find(control))
    orders_.push_back({.kind = RemoteOrder::Kind::Trigger, .number = found->number, .received = {}});
}

const BodyPose* pose_of(const RemoteBodies* bodies, const OscObject& object) {
  if (bodies == nullptr || object.world < 0 || object.world >= std::ssize(bodies->worlds)) return nullptr;
  const auto& all = bodies->worlds[static_cast<std::size_t>(object.world)].bodies;
  return object.body >= 0 && object.body < std::ssize(all) ? &all[static_cast<std::size_t>(object.body)]
                                                           : nullptr;
}

std::optional<std::vector<double>> numbers_of(const OscMessage& message, std::size_t first) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < message.values.size(); ++i) {
    const auto* real = std::get_if<double>(&message.values[i]);
    const auto* whole = std::get_if<std::int64_t>(&message.values[i]);
    if (real == nullptr && whole == nullptr) return std::nullopt;
    numbers.push_back(real != nullptr ? *real : static_cast<double>(*whole));
    if (!std::isfinite(numbers.back())) return std::nullopt;
  }
  return numbers;
}

const std::string* text_at(const OscMessage& message, std::size_t at) {
  return at < message.values.size() ? std::get_if<std::string>(&message.values[at]) : nullptr;
}

}  // namespace tactus
