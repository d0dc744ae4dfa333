#include <algorithm>
#include <vector>

#include "engine/graph/file/read_graph.h"
#include "engine/rig/drive_entry.h"
#include "engine/scene/file/scene_checks.h"
#include "engine/scene/file/scene_fields.h"
#include "engine/scene/file/scene_sections.h"

namespace tactus {

void read_drives(const Value::Table& scene, const std::filesystem::path& folder,
                 const std::filesystem::path& root, SceneSpec& spec, ErrorList& mistakes) {
  for (const auto& entry :
       read_entries(scene, "drives", "{ profile = \"woofer\", volts_per_full_scale = \"10 V\" }", mistakes)) {
    spec.drive_places[entry.name] = entry.at;
    if (entry.broken) continue;
    FieldReader{entry.fields, drive_fields(), mistakes};
    spec.drives.named[entry.name] = read_drive(entry, {folder, root, root}, mistakes).limits;
  }
}

void check_drives(const SceneSpec& scene, ErrorList& mistakes) {
  const auto* instrument = scene.part("instrument");
  if (instrument == nullptr || instrument->graph == nullptr || instrument->graph->incomplete) return;
  std::vector<std::string> names;
  for (const auto& output : instrument->graph->outputs) {
    const auto* kind = find(output.fields, "kind");
    if (kind == nullptr || kind->text() == nullptr || *kind->text() != "audio") names.push_back(output.name);
  }
  for (const auto& [name, at] : scene.drive_places) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    mistakes.add(Errc::UnknownName, at, "the instrument has no drive '" + name + "'",
                 suggest(name, names, names.empty() ? "it has none" : "it has " + listed(names)));
  }
}

}  // namespace tactus
