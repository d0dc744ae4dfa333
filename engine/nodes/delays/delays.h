#pragma once

#include <vector>

#include "engine/graph/node_type.h"

// Thread: [control]

namespace tactus {

const NodeType& delay_type();   ///< fixed or moving delay
const NodeType& string_type();  ///< tuned loop of delay and losses
const NodeType& align_type();   ///< pads a loop to a whole number of periods

/// The family's types, in the order of the reference.
inline std::vector<const NodeType*> delays_types() { return {&delay_type(), &string_type(), &align_type()}; }

}  // namespace tactus
