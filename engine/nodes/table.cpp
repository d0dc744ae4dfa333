#include "engine/nodes/table.h"

namespace tactus {

const NodeTable& standard_nodes() {
  static const NodeTable table = {
      .types = {},
      .network = {},
  };
  return table;
}

}  // namespace tactus
