#include <fmt/format.h>

#include <cmath>

#include "apps/nodes/schema.h"
#include "engine/graph/file/read_graph.h"
#include "engine/rig/profile.h"
#include "engine/rig/rig.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/measures/measure.h"

namespace tactus {
namespace {

std::string range_of(const FieldType& field) {
  if (!field.choices.empty()) return fmt::format("`{}`", fmt::join(field.choices, "`, `"));
  const auto dimension = parse_unit(field.unit).value_or(Unit{}).dimension;
  const auto number = [&](double si) { return std::isfinite(si) ? short_quantity(si, dimension) : "any"; };
  if (!std::isfinite(field.low) && !std::isfinite(field.high)) return "";
  return number(field.low) + " to " + number(field.high);
}

/// The keys of a section and, after it, those of the sections in it. `title` is its path: "scene",
/// "[expect]".
std::string table_of(const std::string& title, const SectionType& section) {
  auto text = fmt::format("\n### {}\n\n{}.\n\n| key | range | default | meaning |\n|---|---|---|---|\n",
                          title, section.doc);
  for (const auto& field : section.fields)
    text += fmt::format("| `{}` | {} | {} | {} |\n", field.key, field.key == "measure" ? "" : range_of(field),
                        field.required ? "required" : field.fallback, field.doc);
  for (const auto& field : section.fields)
    if (field.inside != nullptr)
      text += table_of(field.kind == FieldType::Kind::Entries ? fmt::format("entries of [{}]", field.key)
                                                              : fmt::format("[{}]", field.key),
                       *field.inside);
  return text;
}

std::string unit_of(const Measure& type) {
  return type.unit == Measure::kUnitOfSubject ? "that of the signal" : type.unit;
}

std::string measure_tables() {
  static constexpr const char* kOf[] = {"the scene", "a signal", "events", "a port", "[playability]"};
  std::string text =
      "\n## Measures\n\nIn `[expect]`. Events are the triggers of a signal, or the strikes in a force: "
      "pulses above 5 N, at least 5 ms apart.\n\n| measure | of | unit | meaning |\n|---|---|---|---|\n";
  for (const auto& type : measures())
    if (type.value != nullptr)
      text +=
          fmt::format("| `{}` | {}{} | {} | {} |\n", type.name, kOf[static_cast<int>(type.subject)],
                      type.of.empty() ? "" : ", else the role `" + type.of + "`", unit_of(type), type.doc);
  text += "\nIn `[accuracy]`.\n\n| measure | unit | error |\n|---|---|---|\n";
  for (const auto& type : measures())
    if (type.error != nullptr)
      text += fmt::format("| `{}` | {} | {} |\n", type.name, unit_of(type), type.error_doc);
  return text;
}

}  // namespace

std::string file_reference() {
  return "\n## Keys of files\n" + table_of("Graph", graph_fields()) +
         table_of("Part in a graph", part_fields()) + table_of("Scene", scene_fields()) +
         table_of("Rig", rig_fields()) + table_of("Actuator profile", profile_fields()) + measure_tables();
}

}  // namespace tactus
