#pragma once

#include <vector>

#include "engine/graph/node_type.h"

// Thread: [control]

namespace tactus {

const NodeType& clip_type();        ///< limits a signal to a range
const NodeType& map_type();         ///< function given as a table of points
const NodeType& mix_type();         ///< sum of all lanes of a signal
const NodeType& quantiser_type();   ///< rounds to multiples of a step
const NodeType& hysteresis_type();  ///< backlash (play operator)
const NodeType& slew_type();        ///< limits the rate of change

/// The family's types, in the order of the reference.
inline std::vector<const NodeType*> shapers_types() {
  return {&clip_type(), &map_type(), &mix_type(), &quantiser_type(), &slew_type(), &hysteresis_type()};
}

}  // namespace tactus
