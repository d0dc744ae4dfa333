#include "apps/live/knobs.h"

#include <algorithm>
#include <cmath>

#include "engine/graph/entry_fields.h"

namespace tactus::app {

void Knobs::renew() {
  std::vector<Knob> now;
  for (const auto& scheduled : engine_.schedule().controls) {
    const auto& control = scheduled.control;
    Knob knob{control.name, control.about,   control.value,   control.range,
              control.unit, control.decibel, scheduled.frozen};
    const auto before =
        std::find_if(knobs_.begin(), knobs_.end(), [&](const Knob& old) { return old.name == knob.name; });
    if (before != knobs_.end() && !knob.frozen) knob.value = before->value;
    now.push_back(std::move(knob));
  }
  knobs_ = std::move(now);
}

double Knobs::place(std::size_t index) const {
  const auto& knob = knobs_[index];
  const auto [low, high] = std::pair{knob.range.low, knob.range.high};
  if (!(high > low)) return 0.0;
  if (knob.decibel && low > 0) return std::log(knob.value / low) / std::log(high / low);
  return (knob.value - low) / (high - low);
}

bool Knobs::turn(std::size_t index, double place) {
  auto& knob = knobs_[index];
  const auto [low, high] = std::pair{knob.range.low, knob.range.high};
  if (knob.frozen || !std::isfinite(low) || !std::isfinite(high)) return false;
  const double at = std::clamp(place, 0.0, 1.0);
  const double value = knob.decibel && low > 0 ? low * std::pow(high / low, at) : low + (high - low) * at;
  const int number = engine_.control_index(knob.name);
  if (number < 0 || !engine_.post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, number, value}))
    return false;
  knob.value = value;
  return true;
}

std::string Knobs::text(std::size_t index) const {
  const auto& knob = knobs_[index];
  return knob.name + " = " + in_unit(knob.value, knob.unit);
}

}  // namespace tactus::app
