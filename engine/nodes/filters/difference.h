#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& difference_type();

}  // namespace tactus
