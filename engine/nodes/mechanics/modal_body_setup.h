#pragma once

// Thread: [control].

#include <vector>

#include "engine/dsp/resonators/modal_body.h"
#include "engine/graph/node_type.h"

namespace tactus {

/// What a `modal_body` is made of.
struct BodySetup {
  double impedance = 0;
  std::vector<BodyMode> modes;
};

/// Errors: OutOfRange.
Result<BodySetup> body_setup(const NodeSetup& setup);

}  // namespace tactus
