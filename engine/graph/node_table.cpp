#include "engine/graph/node_table.h"

namespace tactus {

const NodeType* NodeTable::find(std::string_view name) const {
  for (const auto* type : types)
    if (type->name == name) return type;
  return nullptr;
}

}  // namespace tactus
