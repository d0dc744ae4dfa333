#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// A bank of resonators: what rings when it is struck.
const NodeType& modal_type();

}  // namespace tactus
