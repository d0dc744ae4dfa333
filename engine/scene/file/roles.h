#pragma once

#include "engine/graph/file/error_list.h"
#include "engine/scene/file/scene_spec.h"

// Thread: [control]

namespace tactus {

/// What a signal of a scene can be to measures and reports.
struct RoleType {
  std::string name;
  std::string port;  ///< of any part: plays the role where `[roles]` does not name a signal
  std::string doc;
};
const std::vector<RoleType>& role_types();

/// `[roles]` of a scene, whose parts have been read: first those that it names, in its order, then those that
/// ports play by their name.
std::vector<Role> read_roles(const Value::Table& scene, const std::vector<ScenePart>& parts,
                             ErrorList& mistakes);

/// The signal that plays a role; empty if there is none.
std::string signal_of(const std::vector<Role>& roles, std::string_view role);

}  // namespace tactus
