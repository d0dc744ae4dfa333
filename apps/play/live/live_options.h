#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/guard_options.h"

namespace tactus::app {

/// Options of playing on a sound card.
struct LiveOptions {
  std::string target;
  std::string rig, backend, device, input_device;
  std::vector<int> in, out;  ///< channels, from 1
  std::string rate, duration, delay, pad_delay;
  std::optional<int> block, periods;
  std::vector<std::string> set;
  GuardOptions guard;
  std::string record, save_rig, midi;
  std::string learn;  ///< an input, "*" for the first one; empty: nothing is learnt
  bool arm = false, listen = false, yes = false, force = false, json = false;

  /// An option that only a sound card has, given without any card; empty: none.
  std::string stray() const {
    if (!record.empty()) return "--record";
    if (!save_rig.empty()) return "--save-rig";
    if (!learn.empty()) return "--learn";
    if (!midi.empty()) return "--midi";
    if (!pad_delay.empty()) return "--pad-delay";
    if (!in.empty()) return "--inputs";
    if (!out.empty()) return "--outputs";
    if (periods) return "--periods";
    return arm ? "--arm" : "";
  }
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
