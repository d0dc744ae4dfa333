#include "apps/live/knobs.h"

#include <algorithm>
#include <cmath>

#include "apps/midi_map.h"
#include "engine/graph/entry_fields.h"

namespace tactus::app {
namespace {

auto named(std::vector<Knobs::Knob>& knobs, const std::string& name) {
  return std::find_if(knobs.begin(), knobs.end(),
                      [&](const auto& knob) { return knob.control.name == name; });
}

}  // namespace

void Knobs::renew() {
  std::vector<Knob> now;
  for (const auto& scheduled : engine_.schedule().controls) {
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

bool Knobs::move(Knob& knob, double value) {
  const int number = engine_.control_index(knob.control.name);
  if (knob.frozen || number < 0 ||
      !engine_.post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, number, value}))
    return false;
  knob.control.value = value;
  return true;
}

bool Knobs::turn(std::size_t index, double place) {
  auto& knob = knobs_[index];
  return knob.control.range.bounded() && move(knob, value_at(knob.control, place));
}

bool Knobs::set(const std::string& name, double value) {
  const auto knob = named(knobs_, name);
  return knob != knobs_.end() && move(*knob, value);
}

std::string Knobs::text(std::size_t index) const {
  const auto& control = knobs_[index].control;
  return control.name + " = " + in_unit(control.value, control.unit);
}

}  // namespace tactus::app
