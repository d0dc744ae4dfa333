#pragma once

// Thread: [control].

#include <vector>

#include "engine/graph/node_type.h"
#include "engine/nodes/mechanics/proxy_kernel.h"

namespace tactus {

/// The position; stiffness, friction; the place of the solid; what `tactus_solid_of` takes.
inline constexpr int kProxyInputs = 15, kProxyPlace = 5, kProxySolid = 8;

/// Shape and heights of a proxy, from its settings.
struct ProxySetup {
  tactus_solid_shape shape = TACTUS_SOLID_PLANE;
  std::vector<double> heights = {0, 0};
  int rows = 1, columns = 2;
};

/// Errors: Missing, BadArgument, where the heights are no grid.
Result<ProxySetup> proxy_setup(const NodeSetup& setup);

}  // namespace tactus
