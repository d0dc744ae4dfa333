#pragma once

#include <vector>

#include "engine/graph/node_type.h"

// Thread: [control]

namespace tactus {

const NodeType& sine_type();       ///< sine of any frequency
const NodeType& noise_type();      ///< reproducible white noise
const NodeType& wavetable_type();  ///< one period given as numbers, repeated
const NodeType& sample_type();     ///< plays a sound file at each trigger
const NodeType& curve_type();      ///< breakpoint curve over time

/// The family's types, in the order of the reference.
inline std::vector<const NodeType*> generators_types() {
  return {&sine_type(), &noise_type(), &wavetable_type(), &sample_type(), &curve_type()};
}

}  // namespace tactus
