#pragma once

// Thread: [any]
#include "engine/core/find_root.h"  // moved; to be removed once nothing includes it from here
