#pragma once

#include <vector>

#include "engine/graph/node_type.h"

// Thread: [control]

namespace tactus {

const NodeType& envelope_type();  ///< peak follower
const NodeType& decay_type();     ///< exponentially decaying pulse at each trigger
const NodeType& adsr_type();      ///< attack, decay, sustain, release of a gate
const NodeType& onset_type();     ///< hits in a microphone signal

/// The family's types, in the order of the reference.
inline std::vector<const NodeType*> envelopes_types() {
  return {&envelope_type(), &decay_type(), &adsr_type(), &onset_type()};
}

}  // namespace tactus
