#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Virtual spring.
const NodeType& spring_type();

}  // namespace tactus
