#include "remote/remote.h"

#include <algorithm>
#include <cmath>

namespace tactus {

int RemoteDescription::find_control(std::string_view name) const {
  const auto found = std::find_if(controls.begin(), controls.end(),
                                  [&](const auto& control) { return control.name == name; });
  return found == controls.end() ? -1 : static_cast<int>(found - controls.begin());
}

int RemoteDescription::find_gesture(std::string_view name) const {
  const auto found = std::find(gestures.begin(), gestures.end(), name);
  return found == gestures.end() ? -1 : static_cast<int>(found - gestures.begin());
}

double RemoteControl::position() const {
  const auto scaled = [this](double si) { return unit.decibel ? unit.from_si(si) : si; };
  const double bottom = scaled(low), top = scaled(high);
  if (!(std::isfinite(top - bottom) && top > bottom)) return 0.0;
  return std::clamp((scaled(value) - bottom) / (top - bottom), 0.0, 1.0);
}

double RemoteControl::at_position(double position) const {
  const auto scaled = [this](double si) { return unit.decibel ? unit.from_si(si) : si; };
  const double bottom = scaled(low), top = scaled(high);
  if (!(std::isfinite(top - bottom) && top > bottom)) return unit.to_si(initial);
  const double at = std::lerp(bottom, top, std::clamp(position, 0.0, 1.0));
  return std::clamp(unit.decibel ? unit.to_si(at) : at, low, high);
}

}  // namespace tactus
