#pragma once
// Thread: [control]

#include <cstdint>
#include <memory>
#include <string>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "remote/remote.h"

namespace tactus {

struct SerialCounts {
  std::int64_t lines = 0, refused = 0, changes = 0, dropped = 0;
};

struct SerialOptions {
  std::string device;  ///< "/dev/ttyACM0", "COM3"
  int baud = 115200;
};

/// "/dev/ttyACM0", "/dev/ttyUSB0@57600". Errors, at --serial: Syntax.
Result<SerialOptions> parse_serial_device(const std::string& text);

/// Sensors at a serial port, which set controls. A value takes effect kDelay after it came, or after the time
/// that its sensor states: so jitter of the port below that does not matter. The control's own ramp connects
/// the values. A device that is unplugged is opened again when it returns.
class SerialSensors {
 public:
  static constexpr Seconds kDelay{0.015};

  /// Errors, at --serial: Device: it cannot be opened.
  static Result<std::unique_ptr<SerialSensors>> open(const SerialOptions& options, RemoteTarget& target);
  virtual ~SerialSensors() = default;

  /// As of a moment ago.
  virtual SerialCounts counts() const = 0;
};

}  // namespace tactus
