#include "apps/play/live/controls/live_controls.h"

#include <algorithm>
#include <cmath>

#include "engine/core/dimension.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"

namespace tactus::app {
namespace {

auto named(std::vector<LiveControl>& controls, const std::string& name) {
  return std::find_if(controls.begin(), controls.end(),
                      [&](const auto& live) { return live.control.name == name; });
}

}  // namespace

void LiveControls::renew() {
  std::vector<LiveControl> now;
  for (const auto& planned : player_.plan().controls) {
    auto& live = now.emplace_back(LiveControl{planned, planned.control.value});
    const auto before = named(controls_, planned.control.name);
    if (before == controls_.end() || live.frozen) continue;
    const bool kept = before->value_in_file == live.value_in_file;
    const auto& range = live.control.range;
    if (kept) live.control.value = std::clamp(before->control.value, range.low, range.high);
    live.sent = kept && before->sent;  // a value posted before the edit would be applied after it
  }
  controls_ = std::move(now);
  ++version_;
}

double LiveControls::position(std::size_t index) const {
  const auto& control = controls_[index].control;
  const double low = control.range.low, high = control.range.high;
  if (!(high > low)) return 0.0;
  if (control.unit.decibel && low > 0) return std::log(control.value / low) / std::log(high / low);
  return (control.value - low) / (high - low);
}

bool LiveControls::can_change(std::size_t index) const {
  return !controls_[index].frozen && controls_[index].control.range.bounded();
}

bool LiveControls::turn(std::size_t index, double position) {
  auto& live = controls_[index];
  auto& control = live.control;
  if (!can_change(index)) return false;
  const double low = control.range.low, high = control.range.high, at = std::clamp(position, 0.0, 1.0);
  control.value = control.unit.decibel && low > 0 ? low * std::pow(high / low, at) : low + (high - low) * at;
  live.sent = false;
  return true;
}

bool LiveControls::turn(const std::string& name, double position) {
  const auto live = named(controls_, name);
  return live != controls_.end() && turn(static_cast<std::size_t>(live - controls_.begin()), position);
}

bool LiveControls::set(const std::string& name, double value) {
  const auto live = named(controls_, name);
  if (live == controls_.end() || live->frozen) return false;
  live->control.value = std::clamp(value, live->control.range.low, live->control.range.high);
  live->sent = false;
  return true;
}

void LiveControls::note(const std::string& name, double value) {
  const auto live = named(controls_, name);
  if (live == controls_.end()) return;
  live->control.value = value;
  live->sent = true;
}

const LiveControl* LiveControls::find(const std::string& name) const {
  const auto live = std::ranges::find(controls_, name, [](const auto& each) { return each.control.name; });
  return live == controls_.end() ? nullptr : &*live;
}

void LiveControls::send() {
  for (auto& live : controls_)
    if (!live.sent)
      live.sent = player_.post({JournalEntry::kNow, JournalEntry::Kind::ControlChange,
                                player_.control_index(live.control.name), live.control.value});
}

void LiveControls::post_all() {
  std::vector<JournalEntry> start;
  for (auto& live : controls_) {
    if (live.frozen) continue;
    start.push_back(
        {0, JournalEntry::Kind::ControlSet, player_.control_index(live.control.name), live.control.value});
    live.sent = true;
  }
  player_.drop_posted();
  player_.set_journal(std::move(start));
}

std::string LiveControls::text(std::size_t index) const {
  return controls_[index].control.name + " = " + value_text(index);
}

std::string LiveControls::value_text(std::size_t index) const {
  const auto& control = controls_[index].control;
  // Units besides those of SI that people write.
  for (const auto* name : {"rpm", "deg"}) {
    const auto unit = *parse_unit(name);
    if (control.unit.dimension == unit.dimension && control.unit.factor == unit.factor && unit.factor != 1.0)
      return short_number(unit.from_si(control.value)) + " " + name;
  }
  return in_unit(control.value, control.unit);
}

}  // namespace tactus::app
