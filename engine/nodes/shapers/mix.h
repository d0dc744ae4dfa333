#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Sum of all lanes of a signal: the compiler adds them up and this node passes the sum on.
const NodeType& mix_type();

}  // namespace tactus
