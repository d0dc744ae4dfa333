#include "engine/nodes/table.h"

#include "engine/nodes/delays/delays.h"
#include "engine/nodes/envelopes/envelopes.h"
#include "engine/nodes/filters/filters.h"
#include "engine/nodes/generators/generators.h"
#include "engine/nodes/logic/logic.h"
#include "engine/nodes/mechanics/mechanics.h"
#include "engine/nodes/networks/network.h"
#include "engine/nodes/shapers/shapers.h"

namespace tactus {

const NodeTable& standard_nodes() {
  static const NodeTable table = [] {
    NodeTable all{.types = {}, .network = network_type};
    for (const auto family : {generators_types, shapers_types, envelopes_types, filters_types, delays_types,
                              logic_types, mechanics_types})
      for (const auto* type : family()) all.types.push_back(type);
    return all;
  }();
  return table;
}

}  // namespace tactus
