#pragma once

// Thread: [any]
#include "engine/nodes/networks/solver_names.h"  // moved; to be removed once nothing includes it from here
