#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& velocity_type();

}  // namespace tactus
