#include "engine/nodes/table.h"

#include "engine/nodes/adsr.h"
#include "engine/nodes/clip.h"
#include "engine/nodes/counter.h"
#include "engine/nodes/curve.h"
#include "engine/nodes/damper.h"
#include "engine/nodes/decay.h"
#include "engine/nodes/envelope.h"
#include "engine/nodes/latch.h"
#include "engine/nodes/map.h"
#include "engine/nodes/mix.h"
#include "engine/nodes/noise.h"
#include "engine/nodes/onset.h"
#include "engine/nodes/quantiser.h"
#include "engine/nodes/sample.h"
#include "engine/nodes/sample_hold.h"
#include "engine/nodes/sine.h"
#include "engine/nodes/spring.h"
#include "engine/nodes/terrain.h"
#include "engine/nodes/threshold.h"
#include "engine/nodes/wall.h"
#include "engine/nodes/wavetable.h"

namespace tactus {

const NodeTable& standard_nodes() {
  static const NodeTable table = {
      .types =
          {
              &clip_type(),      &map_type(),         &mix_type(),      &sine_type(),    &noise_type(),
              &wavetable_type(), &sample_type(),      &envelope_type(), &decay_type(),   &adsr_type(),
              &threshold_type(), &sample_hold_type(), &latch_type(),    &counter_type(), &quantiser_type(),
              &curve_type(),     &spring_type(),      &damper_type(),   &wall_type(),    &terrain_type(),
              &onset_type(),
          },
      .network = {},
  };
  return table;
}

}  // namespace tactus
