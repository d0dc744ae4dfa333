#pragma once

// Thread: [control]
#include <memory>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/node_type.h"

namespace tactus {

/// The declaration of the one node that `[networks.x]` becomes. Its inputs are the numbers and
/// signals of the elements ("coil.voltage"), its outputs what they can be asked for: "stick.position",
/// "stick" for the first quantity of an element, and "energy" of the whole. What elements there are:
/// `network_elements()`. Errors: those of `read_network_layout`.
Checked<std::shared_ptr<const NodeType>> network_type(const NetworkSpec& spec);

}  // namespace tactus
