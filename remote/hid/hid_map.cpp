#include "remote/hid/hid_map.h"

#include <cmath>

namespace tactus {
namespace {

bool is_meant(const RigHid& source, const HidEvent& event) {
  return source.part == event.part && source.number == event.number &&
         event.device.find(source.device) != std::string::npos;
}

}  // namespace

std::vector<RemoteOrder> HidMap::handle(const HidEvent& event, RemoteTarget& target) {
  if (moved_far(event)) {
    const RigHid source{{}, {}, event.device, event.part, event.number, false};
    if (target.learn_hid(source)) return {};  // also where it moves another control
    if (event.part == HidPart::Axis) first_[{event.device, event.number}] = event.position;
  }
  std::vector<RemoteOrder> orders;
  const auto description = target.description();
  for (const auto& control : description->controls) {
    if (!control.hid || control.constant || !is_meant(*control.hid, event)) continue;
    const double position = control.hid->invert ? 1.0 - event.position : event.position;
    orders.push_back({.number = control.number, .value = control.at_position(position), .received = {}});
  }
  return orders;
}

bool HidMap::moved_far(const HidEvent& event) {
  if (event.part == HidPart::Button) return event.position > 0.5;
  const auto [first, is_new] = first_.try_emplace({event.device, event.number}, event.position);
  return !is_new && std::abs(event.position - first->second) >= kLearnShare;
}

void HidMap::forget(const std::string& device) {
  std::erase_if(first_, [&](const auto& entry) { return entry.first.first == device; });
}

}  // namespace tactus
