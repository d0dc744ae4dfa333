#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Generator that repeats one period given as numbers.
const NodeType& wavetable_type();

}  // namespace tactus
