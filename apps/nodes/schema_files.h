#pragma once

#include "apps/nodes/schema_pieces.h"

namespace tactus::schema {

/// Of files: what each may hold.
Json graph();
Json scene();
Json profile();
Json rig();

/// Of what several of them hold. A node of a graph is an expression, a part, or of a type.
Json any_node();
Json part();
/// What an actuator is, for its guard.
Json drive();

}  // namespace tactus::schema
