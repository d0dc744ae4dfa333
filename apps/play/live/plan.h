#pragma once
// Thread: [control]

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/backends.h"
#include "apps/cli/console.h"
#include "apps/play/live/live_options.h"
#include "apps/play/live/performer.h"

namespace tactus::app {

/// All that a session is made from.
struct Plan {
  ChosenDevices devices;
  StreamRequest request;
  std::unique_ptr<Performer> performer;
  std::optional<Rig> rig;
  std::string rig_file;                           ///< where it is kept, or empty
  std::optional<double> delay_s;                  ///< of the card, measured
  std::optional<int> delay_block, delay_periods;  ///< that it was measured with, where that is known
  int padding_frames = 0;
};

/// The command line and the rig, the former first, turned into what a session needs. Asks and learns what is
/// asked for, and opens nothing else yet.
tl::expected<Plan, Refusal> make_plan(const LiveOptions& options);

/// What was granted, and beside it what was asked for where it is something else.
std::string granted_in_words(const Plan& plan, const StreamGranted& granted);
/// Does the measured delay hold for what was granted? It is taken back with a warning if not. Errors:
/// BadArgument where frames were to be added to it.
Status check_delay(Plan& plan, const StreamGranted& granted);
/// The system delay that the instrument uses, and its source.
std::string delay_in_words(const Plan& plan);

}  // namespace tactus::app
