#pragma once
// Thread: [control]

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/backends.h"
#include "apps/play/live/performer.h"
#include "apps/play/live/remote/remote_options.h"
#include "apps/play/live/session.h"
#include "apps/play/play_report.h"

namespace tactus::app {

/// Options of playing on a sound card.
struct LiveOptions : PlayerOptions, DeviceOptions, RemoteOptions {
  std::vector<int> in_channels, out_channels;  ///< from 1
  std::string pad_delay;
  std::string record, save_rig;
  std::string learn;  ///< an input, "*" for the first one; empty: no sensitivity is learnt
  bool arm = false, shared_port = false, listen = false, awake = false, yes = false, force = false;

  /// Is a sound card asked for at all?
  bool live() const {
    return listen || !rig.empty() || !backend.empty() || !device.empty() || !input_device.empty();
  }
};

/// Plays until the user, the duration or the device ends it. The program's exit status.
int play_live(const LiveOptions& options);

/// What a session is made from.
struct LivePlan : PerformerSetup {
  ChosenDevices devices;
  StreamRequest request;
  std::unique_ptr<Performer> performer;
  std::string rig_file;          ///< or empty
  bool delay_assumed = false;    ///< given by hand, not measured
  DelaySettings delay_settings;  ///< that the delay was measured with, where that is known
};

/// The plan by the command line and the rig, the former first. Asks for a rig and learns a sensitivity where
/// that is an option, and opens nothing else yet. Throws a CommandError.
LivePlan make_plan(const LiveOptions& options);

/// What was granted, and beside it what was asked for where it is something else.
std::string granted_text(const LivePlan& plan, const StreamGranted& granted);
/// Is the measured delay valid for what was granted? If not, it is dropped with a warning. From then on it is
/// valid for what was granted alone. Throws a CommandError where frames were to be added to it.
void check_delay(LivePlan& plan, const StreamGranted& granted);
/// The system delay that the instrument uses, and its source.
std::string delay_text(const LivePlan& plan);

}  // namespace tactus::app
