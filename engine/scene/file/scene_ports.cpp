#include <optional>
#include <string>
#include <vector>

#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/scope.h"
#include "engine/scene/file/scene_checks.h"
#include "engine/scene/file/scene_fields.h"
#include "engine/scene/file/scene_sections.h"

namespace tactus {
namespace {

std::string signal_called(const EntrySpec& entry, const char* key, Source& at, ErrorList& mistakes) {
  const auto* value = find(entry.fields, key);
  if (value == nullptr) {
    if (!entry.broken)
      mistakes.add(Errc::Missing, entry.at, "port '" + entry.name + "' has no '" + key + "'",
                   std::string{"name an output of the plant, as in "} + key + " = \"plant." + key + "\"");
    return {};
  }
  at = value->at;
  return mistakes.text(entry.fields, key);
}

Port read_port(const EntrySpec& entry, ErrorList& mistakes) {
  Port port;
  port.name = entry.name;
  port.at = port.force_at = port.position_at = entry.at;
  FieldReader fields{entry.fields, port_fields(), mistakes};
  port.force = signal_called(entry, "force", port.force_at, mistakes);
  port.position = signal_called(entry, "position", port.position_at, mistakes);
  if (!fields.has("active_up_to") && !entry.broken)
    mistakes.add(Errc::Missing, entry.at, "port '" + entry.name + "' does not say what is allowed",
                 "write active_up_to = \"10 mJ\" with what its springs can store");
  port.allowed = fields.number("active_up_to").value_or(0);
  return port;
}

/// All outputs of the parts around the instrument.
std::vector<std::string> outputs_around(const SceneSpec& scene) {
  std::vector<std::string> names;
  for (const auto& part : scene.parts)
    if (part.name != "instrument" && part.graph != nullptr)
      for (const auto& output : part.graph->outputs) names.push_back(part.name + "." + output.name);
  return names;
}

/// The unit of an output; nothing, and a mistake where that is certain, if there is none of that name.
std::optional<Dimension> dimension_of(const SceneSpec& scene, const std::string& signal, const Source& at,
                                      ErrorList& mistakes) {
  if (signal.empty()) return std::nullopt;
  const auto dot = signal.find('.');
  const auto* part = scene.part(signal.substr(0, dot));
  if (scene.incomplete || (part != nullptr && (part->graph == nullptr || part->graph->incomplete)))
    return std::nullopt;
  const bool around = part != nullptr && part->name != "instrument" && dot != std::string::npos;
  const auto* output = around ? find_entry(part->graph->outputs, signal.substr(dot + 1)) : nullptr;
  if (output == nullptr) {
    const auto known = outputs_around(scene);
    mistakes.add(Errc::UnknownName, at, "no part around the instrument has an output '" + signal + "'",
                 suggest(signal, known));
    return std::nullopt;
  }
  const auto* unit = find(output->fields, "unit");
  if (unit == nullptr) return Dimension{};
  const auto parsed = unit->text() == nullptr ? std::nullopt : parse_unit(*unit->text());
  return parsed ? std::optional{parsed->dimension} : std::nullopt;
}

}  // namespace

std::vector<Port> read_ports(const Value::Table& scene, ErrorList& mistakes) {
  std::vector<Port> ports;
  NameSpace names;
  for (const auto& entry : read_entries(
           scene, "ports", "{ force = \"plant.motor\", position = \"plant.arm\", active_up_to = \"10 mJ\" }",
           mistakes)) {
    names.add(entry.name, "a port", entry.at, mistakes);
    ports.push_back(read_port(entry, mistakes));
  }
  return ports;
}

void check_ports(const SceneSpec& scene, ErrorList& mistakes) {
  for (const auto& port : scene.ports) {
    const auto force = dimension_of(scene, port.force, port.force_at, mistakes);
    const auto position = dimension_of(scene, port.position, port.position_at, mistakes);
    if (force && position && !(*force * *position == parse_unit("J")->dimension))
      mistakes.add(Errc::UnitMismatch, port.at,
                   "'" + port.force + "' times a change of '" + port.position + "' is no energy",
                   "name a force in N and a position in m, or a torque in N m and an angle");
  }
}

}  // namespace tactus
