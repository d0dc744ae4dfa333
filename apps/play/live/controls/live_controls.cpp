#include "apps/play/live/controls/live_controls.h"

#include <algorithm>
#include <cmath>

#include "engine/graph/file/read_graph.h"

namespace tactus::app {
namespace {

auto named(std::vector<PlannedControl>& controls, const std::string& name) {
  return std::find_if(controls.begin(), controls.end(),
                      [&](const auto& live) { return live.control.name == name; });
}

}  // namespace

void LiveControls::renew() {
  auto now = player_.plan().controls;
  for (auto& live : now)
    if (const auto before = named(controls_, live.control.name); before != controls_.end() && !live.frozen)
      live.control.value = before->control.value;
  controls_ = std::move(now);
}

double LiveControls::position(std::size_t index) const {
  const auto& control = controls_[index].control;
  const double low = control.range.low, high = control.range.high;
  if (!(high > low)) return 0.0;
  if (control.unit.decibel && low > 0) return std::log(control.value / low) / std::log(high / low);
  return (control.value - low) / (high - low);
}

bool LiveControls::turn(std::size_t index, double position) {
  auto& control = controls_[index].control;
  const int number = player_.control_index(control.name);
  if (controls_[index].frozen || number < 0 || !control.range.bounded()) return false;
  const double low = control.range.low, high = control.range.high, at = std::clamp(position, 0.0, 1.0);
  const double value =
      control.unit.decibel && low > 0 ? low * std::pow(high / low, at) : low + (high - low) * at;
  if (!player_.post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, number, value})) return false;
  control.value = value;
  return true;
}

bool LiveControls::turn(const std::string& name, double position) {
  const auto live = named(controls_, name);
  return live != controls_.end() && turn(static_cast<std::size_t>(live - controls_.begin()), position);
}

bool LiveControls::post_all() {
  return std::ranges::all_of(controls_, [&](const auto& live) {
    const int number = player_.control_index(live.control.name);
    return live.frozen || number < 0 ||
           player_.post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, number, live.control.value});
  });
}

std::string LiveControls::text(std::size_t index) const {
  const auto& control = controls_[index].control;
  return control.name + " = " + in_unit(control.value, control.unit);
}

}  // namespace tactus::app
