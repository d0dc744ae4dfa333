#include "engine/nodes/table.h"

#include "engine/nodes/delays/align.h"
#include "engine/nodes/delays/delay.h"
#include "engine/nodes/delays/string.h"
#include "engine/nodes/envelopes/adsr.h"
#include "engine/nodes/envelopes/decay.h"
#include "engine/nodes/envelopes/envelope.h"
#include "engine/nodes/envelopes/onset.h"
#include "engine/nodes/filters/band_pass.h"
#include "engine/nodes/filters/dc_blocker.h"
#include "engine/nodes/filters/difference.h"
#include "engine/nodes/filters/fir.h"
#include "engine/nodes/filters/high_pass.h"
#include "engine/nodes/filters/low_pass.h"
#include "engine/nodes/filters/modal.h"
#include "engine/nodes/filters/one_pole.h"
#include "engine/nodes/filters/velocity.h"
#include "engine/nodes/generators/curve.h"
#include "engine/nodes/generators/noise.h"
#include "engine/nodes/generators/sample.h"
#include "engine/nodes/generators/sine.h"
#include "engine/nodes/generators/wavetable.h"
#include "engine/nodes/logic/counter.h"
#include "engine/nodes/logic/latch.h"
#include "engine/nodes/logic/sample_hold.h"
#include "engine/nodes/logic/threshold.h"
#include "engine/nodes/mechanics/damper.h"
#include "engine/nodes/mechanics/modal_body.h"
#include "engine/nodes/mechanics/spring.h"
#include "engine/nodes/mechanics/terrain.h"
#include "engine/nodes/mechanics/wall.h"
#include "engine/nodes/mechanics/waveguide.h"
#include "engine/nodes/networks/network.h"
#include "engine/nodes/shapers/clip.h"
#include "engine/nodes/shapers/map.h"
#include "engine/nodes/shapers/mix.h"
#include "engine/nodes/shapers/quantiser.h"
#include "engine/nodes/shapers/slew.h"

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
