#pragma once

#include <optional>
#include <string>

#include "backends/paced/paced_stream.h"
#include "engine/core/error.h"

namespace tactus {

/// A device id without its "comedi:": the file of the device, and settings after it,
///   /dev/comedi0,in_range=1,out_range=0,reference=diff,wait=busy,core=3,priority=80
struct ComediSettings {
  enum class Reference { Ground, Common, Differential, Other };

  std::string file;
  std::optional<int> in_range, out_range;   ///< numbers of the driver; without: the widest range
  Reference reference = Reference::Ground;  ///< of the inputs
  PacedSettings pace;
};

/// [any] Errors: BadArgument for a setting that does not exist or has no such value.
Result<ComediSettings> comedi_settings(const std::string& text);

}  // namespace tactus
