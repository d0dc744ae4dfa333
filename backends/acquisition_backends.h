#pragma once

#include <vector>

#include "backends/backend.h"

namespace tactus {

/// [control] For data acquisition cards: see backend.h.
const std::vector<BackendType>& acquisition_backends();

}  // namespace tactus
