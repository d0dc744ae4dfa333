#include "remote/remote.h"

#include <algorithm>

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

}  // namespace tactus
