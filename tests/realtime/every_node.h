#pragma once

#include <memory>
#include <string>

#include "engine/core/error.h"
#include "engine/graph/node_type.h"
#include "engine/graph/plan/plan.h"

namespace tactus::realtime {

/// A graph with a node of every type of the table, alone and as eight voices, on a loop where the type allows
/// it, and a network with every kind of element; each is read by a tap. One input, `x`, goes straight to a
/// drive, twice as loud as full scale; one control, `amount`. `sound_file` is for the types that play one,
/// from the folder `folder`. The edited version has other constants, other numbers that nodes are made from,
/// and a node more. Errors: those of the compiler.
Checked<std::unique_ptr<Plan>> every_node(const NodeTable& table, const std::string& folder,
                                          const std::string& sound_file, bool edited = false);

}  // namespace tactus::realtime
