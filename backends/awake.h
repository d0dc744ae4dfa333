#pragma once
// Thread: [control]

#include <fstream>
#include <utility>

#include "engine/core/error.h"

namespace tactus {

/// Processors do not fall asleep while it exists. Otherwise each block begins on one that wakes up: later,
/// and several times as slow. Costs power and heat, since idle processors run.
class Awake {
 public:
  /// Holds a latency of 0 µs in `file` until it is closed (Linux: Documentation/power/pm_qos_interface.rst).
  /// Errors: Device, with what to do.
  static Result<Awake> begin(const char* file = "/dev/cpu_dma_latency");

 private:
  explicit Awake(std::ofstream held) : held_(std::move(held)) {}

  std::ofstream held_;
};

}  // namespace tactus
