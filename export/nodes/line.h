#pragma once

// Thread: [control].

#include <bit>
#include <string>

#include "engine/dsp/delays/taps_kernel.h"
#include "export/nodes/node_writer.h"

namespace tactus {

/// A line that remembers `longest` samples, of which up to `run` are read in a row. What is constant of it is
/// so for the compiler as well.
class WrittenLine {
 public:
  WrittenLine(NodeWriter& node, int longest, int run) {
    const int capacity = static_cast<int>(std::bit_ceil(static_cast<unsigned>(longest)));
    const auto samples = node.state<double>("tactus_real", "samples", capacity + run);
    next_ = node.state<int>("int", "next");
    name_ = node.frame_variable(
        "tactus_line", "line",
        "{" + samples + ", " + std::to_string(capacity) + ", " + std::to_string(run) + ", " + next_ + "}");
  }
  /// How code refers to it.
  std::string text() const { return "&" + name_; }
  /// Behind what writes to it.
  std::string keep() const { return next_ + " = " + name_ + ".next;"; }

 private:
  std::string name_, next_;
};

}  // namespace tactus
