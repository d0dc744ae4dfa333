#pragma once

#include "engine/graph/node_type.h"

// Thread: [control].

namespace tactus {

/// [any] Every node type that comes with Tactus, by family.
const NodeTable& standard_nodes();

// Each type is declared beside its node; the table adds its family.
NodeType sine_type(), noise_type(), wavetable_type(), sample_type(), curve_type();
NodeType clip_type(), map_type(), mix_type(), quantiser_type(), slew_type(), hysteresis_type();
NodeType envelope_type(), decay_type(), adsr_type(), onset_type();
NodeType one_pole_type(), low_pass_type(), high_pass_type(), band_pass_type(), fir_type(), modal_type();
NodeType dc_blocker_type(), difference_type(), velocity_type();
NodeType delay_type(), string_type(), align_type();
NodeType threshold_type(), sample_hold_type(), latch_type(), counter_type();
NodeType spring_type(), damper_type(), wall_type(), terrain_type(), modal_body_type(), waveguide_type();

}  // namespace tactus
