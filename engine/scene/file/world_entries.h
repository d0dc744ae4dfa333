#pragma once

// Thread: [control]

#include <string>

#include "engine/graph/plan/compile.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// A gesture as a node of the graph around the instrument.
NodeSpec gesture_node(const Gesture& gesture);

/// What is set from outside takes the place of what `fields` say about `port`, if they do.
void overwrite(Value::Table& fields, const std::string& port, const ControlValue& value, const Source& at);

/// Where `part` has a control `strike`, its `node` follows one of this name of the `world`, from 0 to 1.
void strike_by_hand(const GraphSpec& part, NodeSpec& node, GraphSpec& world);

}  // namespace tactus
