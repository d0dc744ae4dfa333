#include "engine/scene/scene_drives.h"

#include <algorithm>
#include <vector>

#include "engine/graph/nearest.h"
#include "engine/graph/part_path.h"
#include "engine/graph/read_graph.h"
#include "engine/scene/scene_sections.h"

namespace tactus {
namespace {

/// One entry of [drives].
class DriveReader {
 public:
  DriveReader(const EntrySpec& entry, const std::filesystem::path& folder, const std::filesystem::path& root,
              Mistakes& mistakes)
      : entry_(entry), folder_(folder), root_(root), mistakes_(mistakes) {}

  DriveLimits read() {
    static const std::vector<std::string> kKeys = {"profile", "volts_per_full_scale", "ceiling", "about"};
    mistakes_.unknown_keys(entry_.fields, kKeys);
    mistakes_.text(entry_.fields, "about");
    auto limits = read_profile().value_or(cautious_limits());
    lower_ceiling(limits);
    return limits;
  }

 private:
  std::optional<DriveLimits> read_profile() {
    const auto* name = find(entry_.fields, "profile");
    const auto* volts_at = find(entry_.fields, "volts_per_full_scale");
    const auto volts = read_bounded(entry_.fields, "volts_per_full_scale", "V", 1e-3, 1000, mistakes_);
    if ((name == nullptr) != (volts_at == nullptr))
      mistakes_.add(Errc::Missing, entry_.at,
                    std::string{"drive '"} + entry_.name + "' lacks '" +
                        (name == nullptr ? "profile" : "volts_per_full_scale") + "'",
                    "write profile = \"woofer\", volts_per_full_scale = \"10 V\"");
    if (name == nullptr || !volts) return std::nullopt;
    const auto text = mistakes_.text(entry_.fields, "profile");
    if (name->text() == nullptr) return std::nullopt;
    const auto file = path_of(text, name->at);
    if (mistakes_.keep(file) == nullptr) return std::nullopt;
    const auto profile = load_profile(*file);
    if (!profile) return mistakes_.add(profile.error()), std::nullopt;
    auto limits = limits_for(*profile, *volts);
    if (const auto status = check(limits); !status)
      return mistakes_.add(Errc::OutOfRange, entry_.at, status.error().what, status.error().remedy),
             std::nullopt;
    return limits;
  }

  /// A path is the scene's own affair and stays in its folders like that of a part.
  Result<std::filesystem::path> path_of(const std::string& text, const Source& at) const {
    if (!text.ends_with(".toml")) return find_profile(text, root_, at.text());
    return find_part(text, folder_, root_, at).map([](const PartPath& path) {
      return std::filesystem::path{path.name};
    });
  }

  void lower_ceiling(DriveLimits& limits) {
    const auto ceiling = read_bounded(entry_.fields, "ceiling", "", 1e-6, 1, mistakes_);
    if (!ceiling) return;
    if (*ceiling > limits.ceiling)
      return mistakes_.add(Errc::OutOfRange, find(entry_.fields, "ceiling")->at,
                           "a scene cannot raise a limit: the ceiling of '" + entry_.name + "' is " +
                               short_number(limits.ceiling),
                           "lower it, or say --raise-limit ceiling=" + short_number(*ceiling) +
                               " on the command line, if you must");
    limits.ceiling = *ceiling;
  }

  const EntrySpec& entry_;
  const std::filesystem::path& folder_;
  const std::filesystem::path& root_;
  Mistakes& mistakes_;
};

}  // namespace

void read_drives(const Value::Table& scene, const std::filesystem::path& folder,
                 const std::filesystem::path& root, SceneSpec& spec, Mistakes& mistakes) {
  for (const auto& entry :
       read_entries(scene, "drives", "{ profile = \"woofer\", volts_per_full_scale = \"10 V\" }", mistakes)) {
    spec.drive_places[entry.name] = entry.at;
    if (!entry.broken) spec.drives.named[entry.name] = DriveReader{entry, folder, root, mistakes}.read();
  }
}

void check_drives(const SceneSpec& scene, Mistakes& mistakes) {
  const auto* instrument = scene.part("instrument");
  if (instrument == nullptr || instrument->graph == nullptr || instrument->graph->incomplete) return;
  std::vector<std::string> names;
  for (const auto& output : instrument->graph->outputs) {
    const auto* kind = find(output.fields, "kind");
    if (kind == nullptr || kind->text() == nullptr || *kind->text() != "audio") names.push_back(output.name);
  }
  for (const auto& [name, at] : scene.drive_places) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    const auto nearest = nearest_name(name, names);
    mistakes.add(Errc::UnknownName, at, "the instrument has no drive '" + name + "'",
                 !nearest.empty() ? "did you mean '" + nearest + "'?"
                 : names.empty()  ? "it has none"
                                  : "it has " + listed(names));
  }
}

}  // namespace tactus
