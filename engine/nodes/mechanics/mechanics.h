#pragma once

#include <vector>

#include "engine/graph/node_type.h"

// Thread: [control]

namespace tactus {

const NodeType& spring_type();      ///< virtual spring
const NodeType& damper_type();      ///< virtual damper
const NodeType& wall_type();        ///< spring and damper that only push
const NodeType& terrain_type();     ///< detents and textures from a profile of heights
const NodeType& modal_body_type();  ///< body of many modes behind a wave port
const NodeType& waveguide_type();   ///< string behind a wave port

/// The family's types, in the order of the reference.
inline std::vector<const NodeType*> mechanics_types() {
  return {&spring_type(),  &damper_type(),     &wall_type(),
          &terrain_type(), &modal_body_type(), &waveguide_type()};
}

}  // namespace tactus
