#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// A string or rod as it is felt at one end.
const NodeType& waveguide_type();

}  // namespace tactus
