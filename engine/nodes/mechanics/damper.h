#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Virtual damper.
const NodeType& damper_type();

}  // namespace tactus
