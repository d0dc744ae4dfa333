#pragma once

#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/plan/plan.h"
#include "engine/rig/profile.h"
#include "engine/rig/rig.h"

namespace tactus {

/// [control] What of a rig does not fit an instrument, in file order: ports without a channel that are not
/// left out, names that the instrument does not have, units, ranges of controls. An output of kind audio may
/// not go to a channel with an actuator: the guard passes sound that would burn a coil.
std::vector<Error> check_rig(const Rig& rig, const GraphSpec& instrument);

/// [control] The instrument as this rig plays it: outputs that are left out are gone (and with them what only
/// they needed), inputs that are left out rest at 0. Compile this; the same object if nothing is left out.
std::shared_ptr<const GraphSpec> without_left_out(const Rig& rig,
                                                  std::shared_ptr<const GraphSpec> instrument);

/// How the channels of a compiled instrument lie on a card.
struct RigWiring {
  std::vector<int> in_map, out_map;  ///< channels of the card, from 0 on, in the order of the engine's
  std::vector<double> input_scales;  ///< value = scale * sample, in the order of the engine's inputs
  LimitBook limits;                  ///< for `guarded_channels`
};

/// [control] `schedule`: compiled from `without_left_out`, for a rig that passed `check_rig`.
/// Errors: OutOfRange for a port whose lanes are not as many as its channels.
Checked<RigWiring> wire_rig(const Rig& rig, const Plan& schedule);

/// [control] Frames to add so that the system delay is `target` whatever the card's own is. Errors, at
/// `where`: Missing when that was never measured; OutOfRange when it is longer already.
Result<int> padding_frames(std::optional<Seconds> measured, Seconds target, Hertz sample_rate,
                           const std::string& where);

}  // namespace tactus
