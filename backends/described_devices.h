#pragma once

#include <string>

#include "engine/core/error.h"

namespace tactus {

/// A backend whose device ids may describe a device: "loop:delay=960", "comedi:/dev/comedi0,core=3".
class DescribedDevices {
 public:
  virtual ~DescribedDevices() = default;
  /// [control] The device that `id` describes is one of `devices` from now on. Errors: UnknownName where it
  /// describes none; BadArgument or OutOfRange for a setting of one.
  virtual Status add(const std::string& id) = 0;
};

}  // namespace tactus
