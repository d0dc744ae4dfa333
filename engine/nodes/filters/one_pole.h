#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& one_pole_type();

}  // namespace tactus
