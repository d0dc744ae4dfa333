#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/play/play_report.h"

namespace tactus::app {

/// Options of playing on a sound card.
struct LiveOptions : RunOptions {
  std::string rig, backend, device, input_device;
  std::vector<int> in, out;  ///< channels, from 1
  std::string pad_delay;
  std::optional<int> periods;
  std::string record, save_rig, midi;
  std::string learn;  ///< an input, "*" for the first one; empty: no sensitivity is learnt
  bool arm = false, listen = false, yes = false, force = false;

  /// Is a sound card asked for at all?
  bool live() const {
    return listen || !rig.empty() || !backend.empty() || !device.empty() || !input_device.empty();
  }
};

/// The options that only a sound card has.
void add_live_options(CLI::App& command, LiveOptions& options);

/// Plays until the user, the duration or the device ends it. The program's exit status.
int play_live(const LiveOptions& options);

}  // namespace tactus::app
