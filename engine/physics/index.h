#pragma once

// Thread: [any]
#include "engine/core/index.h"  // moved; to be removed once nothing includes it from here
#include "engine/physics/numbers.h"
