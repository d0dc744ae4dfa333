#pragma once

#include "engine/graph/plan/schedule.h"

namespace tactus {

/// [control] Fills `can_rest` and all Readers of a schedule whose steps, controls and channels are there:
/// operations on nothing but controls and numbers, and the places that read what may rest.
void find_what_rests(Schedule& schedule);

}  // namespace tactus
