#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Pads a loop so that once around it is a whole number of periods of the note.
const NodeType& align_type();

}  // namespace tactus
