#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// A body of many modes behind a port for waves of force.
const NodeType& modal_body_type();

}  // namespace tactus
