#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Reproducible white noise.
const NodeType& noise_type();

}  // namespace tactus
