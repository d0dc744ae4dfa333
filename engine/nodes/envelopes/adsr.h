#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Attack, decay, sustain, release envelope of a gate.
const NodeType& adsr_type();

}  // namespace tactus
