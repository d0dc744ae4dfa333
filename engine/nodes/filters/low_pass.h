#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& low_pass_type();

}  // namespace tactus
