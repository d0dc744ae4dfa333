#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& fir_type();

}  // namespace tactus
