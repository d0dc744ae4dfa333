#include "engine/scene/file/roles.h"

#include <algorithm>

#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

bool has(const std::vector<EntrySpec>& entries, const std::string& name) {
  return std::any_of(entries.begin(), entries.end(), [&](const auto& entry) { return entry.name == name; });
}

/// A node of the instrument counts too: its events are recorded.
bool has_port(const ScenePart& part, const std::string& name) {
  if (part.graph == nullptr) return false;
  const auto& nodes = part.graph->nodes;
  return has(part.graph->outputs, name) ||
         (part.name == "instrument" &&
          std::any_of(nodes.begin(), nodes.end(), [&](const auto& node) { return node.name == name; }));
}

}  // namespace

const std::vector<RoleType>& role_types() {
  static const std::vector<RoleType> types = {
      {"monitor", "sound", "the output meant for ears"},
      {"hit", "hit", "the trigger of a detected strike"},
      {"contact", "contact", "the contact force of strikes"},
      {"stick", "stick", "the position of what strikes"},
      {"ball", "ball", "the position of what bounces"},
      {"table", "table", "the position of what it bounces on"},
  };
  return types;
}

std::vector<Role> read_roles(const Value::Table& scene, const std::vector<ScenePart>& parts,
                             ErrorList& mistakes) {
  std::vector<Role> roles;
  std::vector<std::string> known;
  for (const auto& type : role_types()) known.push_back(type.name);
  const auto* section = read_section(scene, "roles", mistakes);
  if (section != nullptr) mistakes.unknown_keys(*section, known);
  for (const auto& field : section != nullptr ? *section : Value::Table{})
    if (auto signal = mistakes.text(*section, field.key); !signal.empty())
      roles.push_back({field.key, std::move(signal), field.value.at, true});
  for (const auto& type : role_types())
    for (const auto& part : parts)
      if (signal_of(roles, type.name).empty() && has_port(part, type.port))
        roles.push_back({type.name, part.name + "." + type.port, part.at});
  return roles;
}

std::string signal_of(const std::vector<Role>& roles, std::string_view role) {
  const auto found = std::find_if(roles.begin(), roles.end(), [&](const Role& r) { return r.name == role; });
  return found == roles.end() ? std::string{} : found->signal;
}

}  // namespace tactus
