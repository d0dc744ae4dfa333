#include "engine/nodes/table.h"

#include "engine/nodes/adsr.h"
#include "engine/nodes/align.h"
#include "engine/nodes/band_pass.h"
#include "engine/nodes/clip.h"
#include "engine/nodes/counter.h"
#include "engine/nodes/curve.h"
#include "engine/nodes/damper.h"
#include "engine/nodes/dc_blocker.h"
#include "engine/nodes/decay.h"
#include "engine/nodes/delay.h"
#include "engine/nodes/difference.h"
#include "engine/nodes/envelope.h"
#include "engine/nodes/fir.h"
#include "engine/nodes/high_pass.h"
#include "engine/nodes/latch.h"
#include "engine/nodes/low_pass.h"
#include "engine/nodes/map.h"
#include "engine/nodes/mix.h"
#include "engine/nodes/modal.h"
#include "engine/nodes/modal_body.h"
#include "engine/nodes/network.h"
#include "engine/nodes/noise.h"
#include "engine/nodes/one_pole.h"
#include "engine/nodes/onset.h"
#include "engine/nodes/quantiser.h"
#include "engine/nodes/sample.h"
#include "engine/nodes/sample_hold.h"
#include "engine/nodes/sine.h"
#include "engine/nodes/slew.h"
#include "engine/nodes/spring.h"
#include "engine/nodes/string.h"
#include "engine/nodes/terrain.h"
#include "engine/nodes/threshold.h"
#include "engine/nodes/velocity.h"
#include "engine/nodes/wall.h"
#include "engine/nodes/waveguide.h"
#include "engine/nodes/wavetable.h"

namespace tactus {

const NodeTable& standard_nodes() {
  // One line a type; the groups are those of the reference.
  // clang-format off
  static const NodeTable table = {
      .types =
          {
              // generators
              &sine_type(),
              &noise_type(),
              &wavetable_type(),
              &sample_type(),
              &curve_type(),
              // shapes
              &clip_type(),
              &map_type(),
              &mix_type(),
              &quantiser_type(),
              &slew_type(),
              // envelopes
              &envelope_type(),
              &decay_type(),
              &adsr_type(),
              // filters
              &one_pole_type(),
              &low_pass_type(),
              &high_pass_type(),
              &band_pass_type(),
              &fir_type(),
              &modal_type(),
              &dc_blocker_type(),
              &difference_type(),
              &velocity_type(),
              // delays
              &delay_type(),
              &string_type(),
              &align_type(),
              // logic
              &onset_type(),
              &threshold_type(),
              &sample_hold_type(),
              &latch_type(),
              &counter_type(),
              // mechanics
              &spring_type(),
              &damper_type(),
              &wall_type(),
              &terrain_type(),
              &modal_body_type(),
              &waveguide_type(),
          },
      .network = network_type,
  };
  // clang-format on
  return table;
}

}  // namespace tactus
