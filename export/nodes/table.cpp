#include "export/nodes/table.h"

#include <algorithm>

namespace tactus {

const NodeExport* find_node_export(std::string_view type) {
  for (const auto family :
       {exported_delays(), exported_envelopes(), exported_filters(), exported_generators(), exported_logic(),
        exported_mechanics(), exported_networks(), exported_shapers()}) {
    const auto found =
        std::ranges::find(family, type, [](const NodeExport& entry) { return std::string_view{entry.type}; });
    if (found != family.end()) return &*found;
  }
  return nullptr;
}

}  // namespace tactus
