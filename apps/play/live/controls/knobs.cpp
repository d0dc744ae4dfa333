#include "apps/play/live/controls/knobs.h"

#include <algorithm>
#include <cmath>

#include "engine/graph/file/entry_fields.h"

namespace tactus::app {
namespace {

auto named(std::vector<Knobs::Knob>& knobs, const std::string& name) {
  return std::find_if(knobs.begin(), knobs.end(),
                      [&](const auto& knob) { return knob.control.name == name; });
}

}  // namespace

void Knobs::renew() {
  std::vector<Knob> now;
  for (const auto& scheduled : engine_.plan().controls) {
    Knob knob{scheduled.control, scheduled.frozen};
    const auto before = named(knobs_, knob.control.name);
    if (before != knobs_.end() && !knob.frozen) knob.control.value = before->control.value;
    now.push_back(std::move(knob));
  }
  knobs_ = std::move(now);
}

std::vector<FlatControl> Knobs::controls() const {
  std::vector<FlatControl> controls;
  for (const auto& knob : knobs_) controls.push_back(knob.control);
  return controls;
}

double Knobs::place(std::size_t index) const {
  const auto& control = knobs_[index].control;
  const double low = control.range.low, high = control.range.high;
  if (!(high > low)) return 0.0;
  if (control.decibel && low > 0) return std::log(control.value / low) / std::log(high / low);
  return (control.value - low) / (high - low);
}

bool Knobs::turn(std::size_t index, double place) {
  auto& [control, frozen] = knobs_[index];
  const int number = engine_.control_index(control.name);
  if (frozen || number < 0 || !control.range.bounded()) return false;
  const double low = control.range.low, high = control.range.high, at = std::clamp(place, 0.0, 1.0);
  const double value = control.decibel && low > 0 ? low * std::pow(high / low, at) : low + (high - low) * at;
  if (!engine_.post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, number, value})) return false;
  control.value = value;
  return true;
}

bool Knobs::turn(const std::string& name, double place) {
  const auto knob = named(knobs_, name);
  return knob != knobs_.end() && turn(static_cast<std::size_t>(knob - knobs_.begin()), place);
}

std::string Knobs::text(std::size_t index) const {
  const auto& control = knobs_[index].control;
  return control.name + " = " + in_unit(control.value, control.unit);
}

}  // namespace tactus::app
