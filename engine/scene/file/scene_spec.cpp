#include "engine/scene/file/scene_spec.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "engine/graph/file/load.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/expression.h"
#include "engine/graph/semantics/scope.h"
#include "engine/scene/file/roles.h"
#include "engine/scene/file/scene_fields.h"
#include "engine/scene/file/scene_sections.h"

namespace tactus {
namespace {

/// False if there is a key that may have been meant as a section, or a section that is none.
bool check_keys(const Value::Table& table, ErrorList& mistakes) {
  const auto keys = scene_fields().keys(), graph_keys = graph_fields().keys();
  const auto among = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto of_graph = [&](const Field& field) {
    return among(graph_keys, field.key) && !among(keys, field.key);
  };
  Value::Table rest = table;
  std::erase_if(rest, of_graph);
  mistakes.unknown_keys(rest, keys);
  for (const auto& field : table)
    if (of_graph(field))
      mistakes.add(Errc::UnknownName, field.at, "'" + field.key + "' belongs in a graph, and this is a scene",
                   "move it to the file of a part");
  return std::all_of(rest.begin(), rest.end(), [&](const Field& field) {
    const bool known = among(keys, field.key);
    const bool section = field.key == "parts" || field.key == "gestures";
    return known && (!section || field.value.table() != nullptr);
  });
}

/// A wire's grammar; what it names is looked up when the scene is put together.
void check_wire(const Value& value, ErrorList& mistakes) {
  if (const auto* text = value.text()) mistakes.keep(parse_expression(*text, text_start(value)));
  if (const auto* lanes = value.list())
    for (const auto& lane : *lanes) check_wire(lane, mistakes);
}

/// What a scene without a name is called: as its file, or the folder that it is the scene of.
std::string name_of_file(const std::filesystem::path& file) {
  const auto folder = file.parent_path().filename();
  return (file.filename() == "scene.toml" && !folder.empty() ? folder : file.stem()).string();
}

class SceneReader {
 public:
  SceneReader(const std::filesystem::path& file, const std::filesystem::path& root)
      : folder_(file.parent_path()), root_(root.empty() ? folder_ : root) {
    scene_.file = {std::make_shared<const std::string>(file.string()), 0, 0};
    mistakes_ = ErrorList{scene_.file};
  }

  LoadedScene read(const Result<Value::Table>& table) {
    if (mistakes_.keep(table) == nullptr) return {std::nullopt, mistakes_.take()};
    read_sections(*table);
    return {std::move(scene_), mistakes_.take()};
  }

 private:
  void read_sections(const Value::Table& table) {
    check_format(table, scene_.file, mistakes_);
    scene_.incomplete = !check_keys(table, mistakes_);
    scene_.name = mistakes_.text(table, "name");
    if (scene_.name.empty()) scene_.name = name_of_file(*scene_.file.file);
    scene_.about = mistakes_.text(table, "about");
    scene_.source = mistakes_.text(table, "source");
    read_times(table);
    read_parts(table);
    scene_.gestures = read_gestures(table, mistakes_);
    scene_.converters = read_converters(table, mistakes_);
    read_drives(table, folder_, root_, scene_, mistakes_);
    scene_.ports = read_ports(table, mistakes_);
    scene_.expect = read_expectations(table, scene_.duration, mistakes_);
    scene_.accuracy = read_accuracy(table, scene_.duration, mistakes_);
    scene_.roles = read_roles(table, scene_.parts, mistakes_);
    scene_.playability = read_playability(table, scene_.duration, scene_.roles, mistakes_);
    scene_.compare = read_comparison(table, mistakes_);
    NameSpace names;
    for (const auto& part : scene_.parts) names.add(part.name, "a part", part.at, mistakes_);
    for (const auto& gesture : scene_.gestures) names.add(gesture.name, "a gesture", gesture.at, mistakes_);
  }

  void read_times(const Value::Table& table) {
    FieldReader fields{table, scene_fields(), mistakes_, FieldReader::kKeysChecked};
    if (const auto seed = fields.number("seed")) scene_.seed = static_cast<std::uint64_t>(*seed);
    if (const auto rate = fields.number("rate")) scene_.rate = Hertz{*rate};
    if (const auto delay = fields.number("delay")) scene_.delay = Seconds{*delay};
    if (const auto duration = fields.number("duration")) scene_.duration = Seconds{*duration};
    if (find(table, "duration") == nullptr)
      mistakes_.add(Errc::Missing, {scene_.file.file, 1, 1}, "'duration' is missing",
                    "say how long the scene lasts, as in duration = \"6 s\"");
  }

  void read_parts(const Value::Table& table) {
    for (const auto& entry : read_entries(table, "parts", "{ use = \"file.toml\" }", mistakes_))
      read_part(entry);
    const auto* section = find(table, "parts");
    const Source at = section ? section->at : Source{scene_.file.file, 1, 1};
    if (scene_.part("plant") == nullptr)
      mistakes_.add(Errc::Missing, at, "the part 'plant' is missing",
                    "under [parts], write plant = { use = \"plant.toml\", … }");
  }

  void read_part(const EntrySpec& entry) {
    ScenePart part{entry.name, entry.at, nullptr, entry.fields};
    std::erase_if(part.wires, [](const Field& field) { return field.key == "use"; });
    for (const auto& wire : part.wires) check_wire(wire.value, mistakes_);
    const auto* use = find(entry.fields, "use");
    if (use == nullptr && !entry.broken)
      mistakes_.add(Errc::Missing, entry.at, "part '" + entry.name + "' has no 'use'",
                    "name its file, as in use = \"" + entry.name + ".toml\"");
    else if (const auto file = mistakes_.text(entry.fields, "use"); use != nullptr && use->text() != nullptr)
      part.graph = load_part(file, use->at);
    scene_.parts.push_back(std::move(part));
  }

  std::shared_ptr<const GraphSpec> load_part(const std::string& use, const Source& at) {
    const auto found = find_part(use, folder_, root_, at);
    const auto* path = mistakes_.keep(found);
    if (path == nullptr) return nullptr;
    if (path->canonical == canonical_path(*scene_.file.file)) {
      mistakes_.add(Errc::Cycle, at, "a scene cannot be a part of itself", "name the file of a graph");
      return nullptr;
    }
    auto loaded = load_graph_leniently(path->name, root_);
    mistakes_.add(std::move(loaded.errors));
    return loaded.spec;
  }

  std::filesystem::path folder_, root_;
  SceneSpec scene_;
  ErrorList mistakes_;
};

template <class Items>
auto* find_named(const Items& items, std::string_view name) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

Checked<SceneSpec> without_mistakes(LoadedScene loaded) {
  if (!loaded.mistakes.empty()) return tl::unexpected(std::move(loaded.mistakes));
  return std::move(*loaded.scene);
}

}  // namespace

const ScenePart* SceneSpec::part(std::string_view called) const { return find_named(parts, called); }
const Gesture* SceneSpec::gesture(std::string_view called) const { return find_named(gestures, called); }
const Port* SceneSpec::port(std::string_view called) const { return find_named(ports, called); }

LoadedScene load_scene_leniently(const std::filesystem::path& path, const std::filesystem::path& root) {
  std::error_code error;
  const auto file = std::filesystem::is_directory(path, error) ? path / "scene.toml" : path;
  return SceneReader{file, root}.read(load_toml(file));
}

LoadedScene parse_scene_leniently(std::string_view text, const std::string& file_name,
                                  const std::filesystem::path& root) {
  return SceneReader{file_name, root}.read(parse_toml(text, file_name));
}

Checked<SceneSpec> load_scene(const std::filesystem::path& path, const std::filesystem::path& root) {
  return without_mistakes(load_scene_leniently(path, root));
}

Checked<SceneSpec> parse_scene(std::string_view text, const std::string& file_name,
                               const std::filesystem::path& root) {
  return without_mistakes(parse_scene_leniently(text, file_name, root));
}

}  // namespace tactus
