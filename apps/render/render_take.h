#pragma once

// Thread: [control]

#include <string>
#include <vector>

#include "apps/cli/guard_options.h"

namespace tactus::app {

/// `tactus render --replay`.
struct ReplayOptions {
  std::string take;    ///< the WAV
  std::string target;  ///< another instrument for its sensors; empty: what was recorded
  std::string out, format;
  int block = 256;
  std::vector<std::string> set;
  std::string delay;
  GuardOptions guard;
  bool json = false;
};

/// Plays a take again and tells whether its drives are the same. Gives the exit code.
int render_take(const ReplayOptions& options);

}  // namespace tactus::app
