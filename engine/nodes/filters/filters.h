#pragma once

#include <vector>

#include "engine/graph/node_type.h"

// Thread: [control]

namespace tactus {

const NodeType& one_pole_type();    ///< first-order low-pass and high-pass
const NodeType& low_pass_type();    ///< resonant low-pass, 12 dB an octave
const NodeType& high_pass_type();   ///< resonant high-pass, 12 dB an octave
const NodeType& band_pass_type();   ///< band-pass with gain 1 at its centre
const NodeType& fir_type();         ///< filter given by its impulse response
const NodeType& modal_type();       ///< bank of resonators
const NodeType& dc_blocker_type();  ///< removes the DC component
const NodeType& difference_type();  ///< rate of change from frame to frame
const NodeType& velocity_type();    ///< low-passed rate of change

/// The family's types, in the order of the reference.
inline std::vector<const NodeType*> filters_types() {
  return {&one_pole_type(), &low_pass_type(),   &high_pass_type(),  &band_pass_type(), &fir_type(),
          &modal_type(),    &dc_blocker_type(), &difference_type(), &velocity_type()};
}

}  // namespace tactus
