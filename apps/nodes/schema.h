#pragma once

#include <string>

#include "engine/graph/node_type.h"

namespace tactus {

/// [control] The keys of all files and the measures of scenes, as the end of docs/nodes.md.
std::string file_reference();

/// [control] What graph, scene, profile and rig files may hold, as JSON Schema (draft 7), made from the
/// declarations of the nodes, the elements of networks and the measures, so that editors complete and check
/// files. Names, units and expressions are strings to it; only the engine checks them.
/// docs/tactus.schema.json is this.
std::string file_schema(const NodeTable& table);

}  // namespace tactus
