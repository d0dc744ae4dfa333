#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& dc_blocker_type();

}  // namespace tactus
