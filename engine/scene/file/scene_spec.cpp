#include "engine/scene/file/scene_spec.h"

#include <algorithm>
#include <system_error>
#include <tuple>
#include <utility>

#include "engine/core/named.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/expression.h"
#include "engine/graph/semantics/scope.h"
#include "engine/scene/measures/measure.h"

namespace tactus {
namespace {

constexpr double kMinPlayabilityWindow_s = 1;  // a roll has a worst second
constexpr Dimension kSecond{.second = 1};

const SectionType& section_fields(std::string_view section) { return *scene_fields()[section].inside; }

/// False if there is a key that may have been meant as a section, or a section that is none.
bool check_keys(const Value::Table& table, ErrorList& errors) {
  const auto keys = scene_fields().keys(), graph_keys = graph_fields().keys();
  const auto among = [](const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  Value::Table rest;
  for (const auto& field : table)
    if (among(keys, field.key) || !among(graph_keys, field.key))
      rest.push_back(field);
    else
      errors.add(Errc::UnknownName, field.at, "'" + field.key + "' is a key of graphs, but this is a scene",
                 "move it to the file of a part");
  errors.unknown_keys(rest, keys);
  return std::ranges::all_of(rest, [&](const Field& field) {
    const bool known = among(keys, field.key);
    const bool section = field.key == "parts" || field.key == "gestures";
    return known && (!section || field.value.table() != nullptr);
  });
}

/// A wire's grammar; what it names is looked up when the scene is put together.
void check_wire(const Value& value, ErrorList& errors) {
  if (const auto* text = value.text()) errors.keep(parse_expression(*text, text_start(value)));
  if (const auto* lanes = value.list())
    for (const auto& lane : *lanes) check_wire(lane, errors);
}

/// What a scene without a name is called: as its file, or the folder that it is the scene of.
std::string name_of_file(const std::filesystem::path& file) {
  const auto folder = file.parent_path().filename();
  return (file.filename() == "scene.toml" && !folder.empty() ? folder : file.stem()).generic_string();
}

// ---- gestures ----

std::optional<double> read_time(const Value& value, const Gesture& gesture, ErrorList& errors) {
  const auto time = read_quantity(value, parse_unit("s").value(), "time");
  if (errors.keep(time) == nullptr) return std::nullopt;
  const double last_s = gesture.points.empty() ? -1 : gesture.points.back().time_s;
  if (*time < 0 || *time > kLongestTime_s)
    errors.add(Errc::OutOfRange, value.at, "the time of a point cannot be " + short_quantity(*time, kSecond),
               "use times between 0 s and one day");
  else if (*time <= last_s)
    errors.add(Errc::OutOfRange, value.at,
               short_quantity(*time, kSecond) + " is not later than the " + short_quantity(last_s, kSecond) +
                   " before it",
               "the times of a gesture must be ascending");
  return std::max(last_s, *time);
}

std::optional<double> read_value(const Value& value, Gesture& gesture, ErrorList& errors) {
  const auto quantity = read_quantity(value);
  if (errors.keep(quantity) == nullptr) return std::nullopt;
  if (quantity->bare) return quantity->si;
  if (std::exchange(gesture.bare, false)) gesture.unit = quantity->unit;
  const auto checked = read_quantity(value, gesture.unit, gesture.name);
  return errors.keep(checked) == nullptr ? std::nullopt : std::optional{*checked};
}

/// Points with errors are reported and left out.
void read_point(const Value& point, Gesture& gesture, ErrorList& errors) {
  const auto* pair = point.list();
  if (pair == nullptr || pair->size() != 2)
    return errors.add(Errc::WrongType, point.at, "a point must be a time and a value",
                      "write for instance [\"0.1 s\", \"2 m/s\"]");
  const auto time = read_time((*pair)[0], gesture, errors);
  const auto value = read_value((*pair)[1], gesture, errors);
  if (time && value) gesture.points.push_back({*time, *value});
}

Gesture read_gesture(const EntrySpec& entry, ErrorList& errors) {
  FieldReader fields{entry, section_fields("gestures"), errors, "gesture"};
  Gesture gesture{entry.name, entry.at, static_cast<Gesture::Curve>(fields.choice("curve").value_or(0))};
  const auto* points = fields.value("points");
  if (points == nullptr) return gesture;
  if (points->list() == nullptr || points->list()->empty()) {
    errors.add(Errc::Missing, points->at, "gesture '" + entry.name + "' has no points",
               "write points = [[\"0 s\", 0], [\"1 s\", 1]]");
    return gesture;
  }
  gesture.bare = true;
  for (const auto& point : *points->list()) read_point(point, gesture, errors);
  return gesture;
}

Converters read_converters(const Value::Table& section, ErrorList& errors) {
  Converters converters;
  FieldReader fields{section, section_fields("converters"), errors};
  if (const auto bits = fields.number("bits")) converters.bits = static_cast<int>(*bits);
  converters.on = !fields.flag("off");
  if (!converters.on && fields.has("bits"))
    errors.add(Errc::Duplicate, fields.value("off")->at,
               "'bits' has no effect while the converters are 'off'", "remove 'off' or 'bits'");
  return converters;
}

Port read_port(const EntrySpec& entry, ErrorList& errors) {
  FieldReader fields{entry, section_fields("ports"), errors, "port"};
  const auto signal = [&](const char* key) { return SignalName{fields.text(key), fields.at(key, entry.at)}; };
  return {entry.name, entry.at, signal("force"), signal("position"),
          fields.number("active_up_to").value_or(0)};
}

// ---- [expect] and [accuracy] ----

MeasureEntry read_measure(const EntrySpec& entry, FieldReader& fields, Seconds duration) {
  MeasureEntry read{entry.name, entry.at};
  if (fields.choice("measure")) read.measure = fields.text("measure");
  read.of = fields.text("of");
  read.of_at = fields.at("of", entry.at);
  std::tie(read.from_s, read.to_s) = fields.window(duration);
  return read;
}

Expectation read_expectation(const EntrySpec& entry, Seconds duration, ErrorList& errors) {
  FieldReader fields{entry, section_fields("expect"), errors, "expectation"};
  const Expectation expectation{read_measure(entry, fields, duration), fields.any("min"), fields.any("max")};
  const auto &min = expectation.min, &max = expectation.max;
  if (!min || !max) return expectation;
  if (!min->bare && !max->bare && !(min->unit.dimension == max->unit.dimension))
    errors.add(Errc::UnitMismatch, fields.value("max")->at, "'min' and 'max' are in different units",
               "give both in the same unit");
  else if (min->si > max->si)
    errors.add(Errc::OutOfRange, fields.value("max")->at, "'max' is below 'min'", "swap them");
  return expectation;
}

Accuracy read_accuracy(const EntrySpec& entry, Seconds duration, ErrorList& errors) {
  FieldReader fields{entry, section_fields("accuracy"), errors, "accuracy"};
  const Accuracy accuracy{read_measure(entry, fields, duration), fields.any("exact"), fields.any("scale")};
  if (const auto* type = find_measure(accuracy.measure);
      type != nullptr && fields.has("exact") && !type->has_exact)
    errors.add(Errc::BadArgument, fields.value("exact")->at, "'" + type->name + "' has no single exact value",
               "remove 'exact'");
  if (accuracy.scale && !(accuracy.scale->si > 0.0))
    errors.add(Errc::OutOfRange, fields.value("scale")->at, "'scale' must be above 0",
               "give the value that counts as a relative error of 1");
  return accuracy;
}

// ---- [roles] ----

/// Whether a part has what plays a role by its name. A node of the instrument counts too: its events are
/// recorded.
bool plays(const ScenePart& part, const RoleType& type) {
  if (part.graph == nullptr) return false;
  const auto& graph = *part.graph;
  const bool instrument = part.name == "instrument";
  if (type.of != RoleType::Of::Signal)
    return find_named(graph.controls, type.port) != nullptr &&
           (part.name == "plant" || type.of == RoleType::Of::Control);
  return find_named(graph.outputs, type.port) != nullptr ||
         (instrument && find_named(graph.nodes, type.port) != nullptr);
}

std::vector<Role>& roles_like(SceneSpec& scene, const RoleType& type) {
  return type.of == RoleType::Of::Signal ? scene.roles : scene.control_roles;
}

void read_roles(const Value::Table& table, SceneSpec& scene, ErrorList& errors) {
  if (const auto* section = read_section(table, "roles", errors)) {
    FieldReader fields{*section, section_fields("roles"), errors};
    for (const auto& field : *section)
      if (const auto* type = find_named(role_types(), field.key); type != nullptr)
        if (auto signal = fields.text(field.key); !signal.empty())
          roles_like(scene, *type).push_back({field.key, std::move(signal), field.value.at, true});
  }
  add_roles_by_name(scene);
}

// ---- [playability] ----

/// "110 Hz", or "wanted.pitch": an output of a part.
void read_pitch(FieldReader& fields, Playability& playability, ErrorList& errors) {
  if (!fields.has("pitch"))
    return errors.add(Errc::Missing, playability.at, "a tone needs the expected 'pitch'",
                      "write pitch = \"110 Hz\", or an output of a part: \"wanted.pitch\"");
  const auto& [value, at] = *fields.value("pitch");
  const auto* text = std::get_if<std::string>(&value);
  if (text != nullptr && !text->empty() && text->front() >= 'a' && text->front() <= 'z')
    playability.pitch = {*text, at};
  else
    playability.pitch_hz = fields.number("pitch").value_or(playability.pitch_hz);
}

std::optional<Playability> read_playability(const Value::Table& section, const Source& at, Seconds duration,
                                            const std::vector<Role>& roles, ErrorList& errors) {
  FieldReader fields{section, section_fields("playability"), errors, "[playability]", at};
  const auto number = [&](const char* key, double fallback, double most = kUnlimited) {
    return fields.number(key, most).value_or(fallback);
  };
  const auto signal = [&](const char* key, const char* role) {
    return fields.has(key) ? SignalName{fields.text(key), fields.value(key)->at}
                           : SignalName{signal_of(roles, role), at};
  };
  const auto kind = fields.choice("kind");
  const double end_s = duration.value > 0 ? duration.value : kLongestTime_s;
  Playability read{static_cast<Playability::Kind>(kind.value_or(0)), at};
  read.from_s = number("from", read.from_s, end_s);
  read.to_s = fields.number("to", end_s);
  read.hits = signal("hits", "hit");
  read.contact = signal("contact", "contact");
  read.fewest = number("fewest", read.fewest);
  read.roll = static_cast<Playability::Roll>(fields.choice("roll").value_or(0));
  read.rate_hz = fields.number("rate");
  read.sound = signal("sound", "monitor");
  read.begin_s = number("begin", read.begin_s, end_s);
  read.quiet = number("quiet", read.quiet);
  if (read.to_s.value_or(end_s) - read.from_s < kMinPlayabilityWindow_s)
    errors.add(Errc::OutOfRange, fields.at("from", at), "the evaluated window is shorter than one second",
               "lower 'from', or raise 'to' or 'duration'");
  if (!kind || read.kind == Playability::Kind::Roll) return kind ? std::optional{read} : std::nullopt;
  read_pitch(fields, read, errors);
  if (read.begin_s > read.from_s)
    errors.add(Errc::OutOfRange, fields.value("begin")->at,
               "'begin' is later than 'from', where the tone must be steady", "raise 'from' (default: 1 s)");
  return read;
}

// ---- [compare] ----

/// `plant.gain = 1` is a table in TOML.
void read_compared(const Value::Table& table, const std::string& prefix, Comparison& comparison,
                   ErrorList& errors) {
  for (const auto& [key, at, value] : table) {
    const auto name = prefix + key;
    if (name == "name") continue;
    if (value.table() != nullptr) {
      read_compared(*value.table(), name + ".", comparison, errors);
    } else if (const auto quantity = read_quantity(value); errors.keep(quantity) != nullptr) {
      comparison.set[name] = quantity->si;
      comparison.places[name] = at;
    }
  }
}

Comparison read_comparison(const Value::Table& section, const Source& at, ErrorList& errors) {
  Comparison comparison{errors.text(section, "name"), at, {}, {}};
  if (comparison.name.empty())
    errors.add(Errc::Missing, at, "[compare] lacks 'name'",
               "add a name, such as name = \"without the pulse\"");
  read_compared(section, "", comparison, errors);
  return comparison;
}

// ---- the whole file ----

class SceneReader {
 public:
  SceneReader(const std::filesystem::path& file, const std::filesystem::path& root,
              const ProfileFolders& profiles)
      : folder_(file.parent_path()), root_(root.empty() ? folder_ : root), profiles_{root_} {
    profiles_.insert(profiles_.end(), profiles.begin(), profiles.end());
    scene_.file = {std::make_shared<const std::string>(file.generic_string()), 0, 0};
    errors_ = ErrorList{scene_.file};
  }

  LoadedScene read(const Result<Value::Table>& table) {
    if (errors_.keep(table) == nullptr) return {std::nullopt, errors_.take()};
    read_sections(*table);
    return {std::move(scene_), errors_.take()};
  }

 private:
  void read_sections(const Value::Table& table) {
    check_format(table, scene_.file, errors_);
    scene_.incomplete = !check_keys(table, errors_);
    scene_.name = errors_.text(table, "name");
    if (scene_.name.empty()) scene_.name = name_of_file(*scene_.file.file);
    scene_.about = errors_.text(table, "about");
    scene_.source = errors_.text(table, "source");
    read_times(table);
    read_parts(table);
    const auto entries = [&](const char* section, const char* example, const auto& read) {
      for (const auto& entry : read_entries(table, section, example, errors_)) read(entry);
    };
    const auto duration = scene_.duration;
    entries("gestures", "{ points = [[\"0 s\", 0], [\"1 s\", 1]] }",
            [&](auto& entry) { scene_.gestures.push_back(read_gesture(entry, errors_)); });
    entries("drives", "{ profile = \"woofer\", volts_per_full_scale = \"10 V\" }",
            [&](auto& entry) { read_drive_entry(entry); });
    entries("ports", "{ force = \"plant.motor\", position = \"plant.arm\", active_up_to = \"10 mJ\" }",
            [&](auto& entry) { scene_.ports.push_back(read_port(entry, errors_)); });
    entries("expect", "{ measure = \"…\", max = 1 }",
            [&](auto& entry) { scene_.expect.push_back(read_expectation(entry, duration, errors_)); });
    entries("accuracy", "{ measure = \"position\", of = \"plant.stick\" }",
            [&](auto& entry) { scene_.accuracy.push_back(read_accuracy(entry, duration, errors_)); });
    read_roles(table, scene_, errors_);
    if (const auto* section = read_section(table, "converters", errors_))
      scene_.converters = read_converters(*section, errors_);
    if (const auto* section = read_section(table, "playability", errors_))
      scene_.playability =
          read_playability(*section, find(table, "playability")->at, duration, scene_.roles, errors_);
    if (const auto* section = read_section(table, "show", errors_)) {
      FieldReader fields{*section, section_fields("show"), errors_};
      const auto [from, to] = fields.window(duration);
      scene_.shown = {from.value_or(0), to};
    }
    if (const auto* section = read_section(table, "compare", errors_))
      scene_.compare = read_comparison(*section, find(table, "compare")->at, errors_);
    check_names();
  }

  void check_names() {
    const auto check = [this](const auto& entries, const char* kind, NameSpace& names) {
      for (const auto& entry : entries) names.add(entry.name, kind, entry.at, errors_);
    };
    using enum NameSpace::Names;
    NameSpace names, ports{AfterDots}, expectations{AfterDots}, accuracies{AfterDots};
    check(scene_.parts, "a part", names);
    check(scene_.gestures, "a gesture", names);
    check(scene_.ports, "a port", ports);
    check(scene_.expect, "an expectation", expectations);
    check(scene_.accuracy, "an entry of [accuracy]", accuracies);
  }

  void read_drive_entry(const EntrySpec& entry) {
    scene_.drive_places[entry.name] = entry.at;
    if (entry.broken) return;
    FieldReader fields{entry, section_fields("drives"), errors_, "drive"};
    const auto drive = read_drive(entry, "[drives]", fields, {folder_, root_, profiles_}, errors_);
    check_ceiling(drive, errors_);
    scene_.drives.named[entry.name] = drive.sources();
  }

  void read_times(const Value::Table& table) {
    FieldReader fields{table, scene_fields().fields, errors_, FieldReader::kKeysChecked};
    if (const auto seed = fields.number("seed")) scene_.seed = static_cast<std::uint64_t>(*seed);
    if (const auto rate = fields.number("rate")) scene_.rate = Hertz{*rate};
    if (const auto delay = fields.number("delay")) scene_.delay = Seconds{*delay};
    if (const auto gain = fields.number("monitor")) scene_.monitor_gain = *gain;
    if (const auto duration = fields.number("duration")) scene_.duration = Seconds{*duration};
    scene_.whole = scene_.duration;
    scene_.duration_at = fields.at("duration", scene_.file);
    if (!fields.has("duration"))
      errors_.add(Errc::Missing, {scene_.file.file, 1, 1}, "'duration' is missing",
                  "give the length of the scene, as in duration = \"6 s\"");
  }

  void read_parts(const Value::Table& table) {
    for (const auto& entry : read_entries(table, "parts", "{ use = \"file.toml\" }", errors_))
      read_part(entry);
    const auto* section = find(table, "parts");
    const Source at = section ? section->at : Source{scene_.file.file, 1, 1};
    if (scene_.parts.empty())
      errors_.add(Errc::Missing, at, "a scene needs an instrument or a plant",
                  "under [parts], write instrument = { use = \"instrument.toml\", … }");
  }

  void read_part(const EntrySpec& entry) {
    ScenePart part{entry.name, entry.at, nullptr, entry.fields};
    std::erase_if(part.wires, [](const Field& field) { return field.key == "use"; });
    for (const auto& wire : part.wires) check_wire(wire.value, errors_);
    const auto* use = find(entry.fields, "use");
    if (use == nullptr && !entry.broken)
      errors_.add(Errc::Missing, entry.at, "part '" + entry.name + "' has no 'use'",
                  "give its file, as in use = \"" + entry.name + ".toml\"");
    else if (const auto file = errors_.text(entry.fields, "use"); use != nullptr && use->text() != nullptr)
      part.graph = load_part(file, use->at);
    scene_.parts.push_back(std::move(part));
  }

  std::shared_ptr<const GraphSpec> load_part(const std::string& use, const Source& at) {
    const auto found = find_part(use, folder_, root_, at);
    const auto* path = errors_.keep(found);
    if (path == nullptr) return nullptr;
    if (path->canonical == canonical_path(*scene_.file.file)) {
      errors_.add(Errc::Cycle, at, "a scene cannot be a part of itself", "give the file of a graph");
      return nullptr;
    }
    auto loaded = load_graph_leniently(path->name, root_);
    errors_.add(std::move(loaded.errors));
    return loaded.spec;
  }

  std::filesystem::path folder_, root_;
  ProfileFolders profiles_;
  SceneSpec scene_;
  ErrorList errors_;
};

std::vector<SceneControl> controls_of(const SceneSpec& scene) {
  std::vector<SceneControl> controls;
  for (const auto& part : scene.parts)
    if (part.graph != nullptr)
      for (const auto& control : part.graph->controls) controls.push_back({&part, &control});
  return controls;
}

}  // namespace

bool is_scene(const Value::Table& file) {
  if (find(file, "parts") != nullptr) return true;
  const bool graph =
      find(file, "nodes") != nullptr || find(file, "networks") != nullptr || find(file, "worlds") != nullptr;
  return !graph && (find(file, "duration") != nullptr || find(file, "gestures") != nullptr);
}

void add_roles_by_name(SceneSpec& scene) {
  for (const auto& type : role_types())
    for (const auto& part : scene.parts)
      if (auto& roles = roles_like(scene, type); signal_of(roles, type.name).empty() && plays(part, type))
        roles.push_back({type.name, part.name + "." + type.port, part.at});
}

const std::vector<RoleType>& role_types() {
  constexpr auto kControl = RoleType::Of::Control, kPlant = RoleType::Of::PlantControl;
  static const std::vector<RoleType> types = {
      {"monitor", "sound", "monitor output"},
      {"hit", "hit", "trigger of a detected strike"},
      {"contact", "contact", "contact force of the strikes"},
      {"stick", "stick", "position of the striking object"},
      {"ball", "ball", "position of the bouncing object"},
      {"table", "table", "position of the surface below the bouncing object"},
      {"table_acceleration", "gamma", "control of the surface's largest acceleration, 1 for that of gravity",
       kControl},
      {"table_frequency", "frequency", "control of the frequency of the surface's motion", kControl},
      {"device_mass", "mass", "control of the moving mass of a device that renders walls", kPlant},
      {"device_damping", "damping", "control of its viscous damping", kPlant},
      {"device_friction", "friction", "control of its dry friction", kPlant},
      {"encoder_step", "step", "control of the step of its position encoder", kPlant},
      {"force_limit", "force_limit", "control of the largest force of its motor", kPlant},
      {"hand_mass", "hand_mass", "control of the mass of the hand on it", kPlant},
      {"hand_damping", "hand_damping", "control of the damping of the hand on it", kPlant},
  };
  return types;
}

std::string signal_of(const std::vector<Role>& roles, std::string_view role) {
  const auto* found = find_named(roles, role);
  return found != nullptr ? found->signal : "";
}

const ScenePart* SceneSpec::part(std::string_view called) const { return find_named(parts, called); }
const Gesture* SceneSpec::gesture(std::string_view called) const { return find_named(gestures, called); }
const Port* SceneSpec::port(std::string_view called) const { return find_named(ports, called); }

std::string SceneControl::name() const {
  return part->name == "instrument" ? spec->name : part->name + "." + spec->name;
}

std::optional<double> SceneControl::constant() const {
  const auto* wire = find(part->wires, spec->name);
  if (wire == nullptr) return spec->control.value;
  const auto number = read_quantity(*wire, spec->control.unit, spec->name);
  return number ? std::optional{*number} : std::nullopt;
}

std::vector<std::string> control_names(const SceneSpec& scene) {
  std::vector<std::string> names;
  for (const auto& control : controls_of(scene)) names.push_back(control.name());
  return names;
}

std::optional<SceneControl> find_control(const SceneSpec& scene, const std::string& name) {
  for (const auto& control : controls_of(scene))
    if (name == control.name() || name == control.part->name + "." + control.spec->name) return control;
  return std::nullopt;
}

std::optional<SceneControl> control_of(const SceneSpec& scene, std::string_view role) {
  return find_control(scene, signal_of(scene.control_roles, role));
}

LoadedScene load_scene_leniently(const std::filesystem::path& path, const std::filesystem::path& root,
                                 const ProfileFolders& profiles) {
  std::error_code error;
  const auto file = std::filesystem::is_directory(path, error) ? path / "scene.toml" : path;
  return SceneReader{file, root, profiles}.read(load_toml(file));
}

LoadedScene parse_scene_leniently(std::string_view text, const std::string& file_name,
                                  const std::filesystem::path& root) {
  return SceneReader{file_name, root, {}}.read(parse_toml(text, file_name));
}

Checked<SceneSpec> load_scene(const std::filesystem::path& path, const std::filesystem::path& root,
                              const ProfileFolders& profiles) {
  auto loaded = load_scene_leniently(path, root, profiles);
  if (!loaded.errors.empty()) return tl::unexpected(std::move(loaded.errors));
  return std::move(*loaded.scene);
}

}  // namespace tactus
