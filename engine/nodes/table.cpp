#include "engine/nodes/table.h"

#include "engine/nodes/band_pass.h"
#include "engine/nodes/dc_blocker.h"
#include "engine/nodes/delay.h"
#include "engine/nodes/difference.h"
#include "engine/nodes/fir.h"
#include "engine/nodes/high_pass.h"
#include "engine/nodes/low_pass.h"
#include "engine/nodes/one_pole.h"
#include "engine/nodes/string.h"
#include "engine/nodes/velocity.h"

namespace tactus {

const NodeTable& standard_nodes() {
  static const NodeTable table = {
      .types =
          {
              // filters and delays
              &band_pass_type(),
              &dc_blocker_type(),
              &delay_type(),
              &difference_type(),
              &fir_type(),
              &high_pass_type(),
              &low_pass_type(),
              &one_pole_type(),
              &string_type(),
              &velocity_type(),
          },
      .network = {},
  };
  return table;
}

}  // namespace tactus
