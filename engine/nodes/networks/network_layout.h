#pragma once

// Thread: [control]
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/physics/network.h"

namespace tactus {

/// `[networks.x]` with its names resolved: which element is joined to which. Numbers are not known yet.
struct NetworkLayout {
  std::vector<NetworkElement> elements;
  Solver solver = Solver::Passive;
  int oversample = 0;  ///< 0: not in the file
};

/// Errors, all in one go: unknown types, keys and elements; ends that are missing, too many, or of
/// the wrong kind; options out of their range. `ports` is filled later.
Checked<NetworkLayout> read_network_layout(const NetworkSpec& spec);

}  // namespace tactus
