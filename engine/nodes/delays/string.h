#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& string_type();

}  // namespace tactus
