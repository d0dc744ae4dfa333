#pragma once

#include <vector>

#include "engine/graph/node_type.h"

// Thread: [control]

namespace tactus {

const NodeType& threshold_type();    ///< comparator with hysteresis: a crossing becomes a trigger
const NodeType& sample_hold_type();  ///< holds the value of the last trigger
const NodeType& latch_type();        ///< set and reset by triggers
const NodeType& counter_type();      ///< counts triggers

/// The family's types, in the order of the reference.
inline std::vector<const NodeType*> logic_types() {
  return {&threshold_type(), &sample_hold_type(), &latch_type(), &counter_type()};
}

}  // namespace tactus
