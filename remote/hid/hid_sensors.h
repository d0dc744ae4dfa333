#pragma once
// Thread: [control]

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "remote/remote.h"

namespace tactus {

/// Joysticks, gamepads, pedals and other devices with axes and buttons (HID), which move controls. By SDL 2.
/// They are read every millisecond; a value takes effect kDelay later, so that the time between two values
/// stays as it was.
class HidSensors {
 public:
  static constexpr Seconds kDelay{0.005};

  /// `device`: only those whose name contains it; empty: all. Devices may come and go. Errors, at --hid:
  /// Device: the library cannot be started.
  static Result<std::unique_ptr<HidSensors>> open(const std::string& device, RemoteTarget& target);
  virtual ~HidSensors() = default;

  /// As of a moment ago.
  virtual std::vector<std::string> devices() const = 0;
  virtual std::int64_t changes() const = 0;
};

}  // namespace tactus
