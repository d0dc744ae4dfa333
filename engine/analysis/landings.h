#pragma once

#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// One landing of a ball on a table that moves.
struct Landing {
  double time_s;   ///< of the touch, from the first sample
  double speed;    ///< towards the table just before [m/s]
  double rebound;  ///< away from the table as it was, less what the ball's own fall took meanwhile [m/s]
};

/// [control] Landings, from the positions of both [m]: where the gap falls to 0 or below, and how it was
/// until then and is once the two are apart again, as if all of the touch happened at its start. Slopes are
/// taken through three samples. A touch that has not ended is none.
std::vector<Landing> landings_of(std::span<const double> ball, std::span<const double> table, Hertz rate);

}  // namespace tactus
