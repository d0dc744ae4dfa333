#pragma once
// Thread: [any] Made once and constant from then on.

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/error.h"

// What a screen shows of an instrument, beside its controls.

namespace tactus {

struct PictureLimit {
  std::string name, value, source;  ///< "travel", "3 mm", "profile woofer"
};

struct PictureOutput {
  std::string name;
  bool drive = false;
  std::vector<PictureLimit> limits;
};

/// Of the simulated world where its name begins with "plant/".
struct PictureSignal {
  std::string name, unit, node;
};

struct PictureNode {
  struct Input {
    std::string port, from;
  };
  std::string path, type, about;
  std::string file;
  int line = 0;
  int loop = -1;         ///< in Picture::loops
  std::string left_out;  ///< why it does not run; empty: it runs
  std::vector<Input> inputs;
  std::vector<std::string> outputs;  ///< signals
};

struct PictureLoop {
  std::vector<std::string> paths;
  int delay_frames = 0;
};

struct PictureFile {
  std::string name, text;

  bool operator==(const PictureFile&) const = default;
};

struct Picture {
  std::string file;
  std::string device;
  double sample_rate_hz = 0.0;
  int block = 0;
  std::optional<double> latency_s;
  bool latency_measured = false;
  std::vector<PictureOutput> outputs;
  std::vector<PictureSignal> signals;  ///< that a scope can show
  std::vector<PictureNode> nodes;
  std::vector<PictureLoop> loops;
  std::vector<PictureFile> files;
};

}  // namespace tactus
