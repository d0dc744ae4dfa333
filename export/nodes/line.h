#pragma once

// Thread: [control].

#include <bit>
#include <string>

#include "engine/dsp/delays/taps_kernel.h"
#include "export/nodes/node_writer.h"

namespace tactus {

/// A line that remembers `longest` samples, of which up to `run` are read in a row. Returns how code refers
/// to it.
inline std::string write_line(NodeWriter& node, int longest, int run) {
  const int capacity = static_cast<int>(std::bit_ceil(static_cast<unsigned>(longest)));
  const auto samples = node.state<double>("tactus_real", "samples", capacity + run);
  const auto line = node.state<tactus_line>("tactus_line", "line");
  node.start(line + ".samples = " + samples + ";");
  node.start(line + ".capacity = " + std::to_string(capacity) + ";");
  node.start(line + ".mirrored = " + std::to_string(run) + ";");
  return line;
}

}  // namespace tactus
