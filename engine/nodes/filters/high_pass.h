#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& high_pass_type();

}  // namespace tactus
