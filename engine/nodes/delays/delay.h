#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

const NodeType& delay_type();

}  // namespace tactus
