#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Hits in a microphone signal: OnsetDetector as a node.
const NodeType& onset_type();

}  // namespace tactus
