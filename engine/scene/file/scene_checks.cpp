
#include <algorithm>
#include <optional>
#include <string>

#include "engine/core/named.h"
#include "engine/graph/file/read_graph.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/measures/measure.h"
#include "engine/scene/scene_wiring.h"

namespace tactus {
namespace {

void add_names(std::vector<std::string>& names, const std::string& part,
               const std::vector<std::string>& more) {
  for (const auto& name : more) names.push_back(part + "." + name);
}

/// Everything that will be recorded, lanes not counted.
std::vector<std::string> recorded_names(const SceneSpec& scene, const NodeTable& table) {
  std::vector<std::string> names;
  for (const auto& part : scene.parts) {
    if (part.graph == nullptr) continue;
    if (part.name == "instrument") {
      add_names(names, part.name, names_of(part.graph->inputs));
      add_names(names, part.name, event_taps(*part.graph, table));
    }
    add_names(names, part.name, names_of(part.graph->outputs));
  }
  return names;
}

/// "plant.string[2]" is a lane of "plant.string", and "instrument.hit" the first output of that node.
bool is_recorded(const std::string& name, const std::vector<std::string>& recorded) {
  const auto whole = name.substr(0, name.find('['));
  return std::ranges::any_of(
      recorded, [&](const std::string& known) { return known == whole || known.starts_with(whole + "."); });
}

/// A part that cannot be read may have anything.
bool may_have_more(const SceneSpec& scene, const std::string& name) {
  const auto* part = scene.part(name.substr(0, name.find('.')));
  return scene.incomplete || (part != nullptr && (part->graph == nullptr || part->graph->incomplete));
}

/// A number of [expect] or [accuracy] beside the measure that it is a value of.
void check_unit(const std::optional<QuantityValue>& number, const MeasureEntry& entry, const Measure& type,
                ErrorList& errors) {
  if (!number || number->bare || type.unit == Measure::kUnitOfSubject) return;
  if (number->unit.dimension == parse_unit(type.unit)->dimension) return;
  errors.add(Errc::UnitMismatch, entry.at,
             "'" + entry.measure + "' is " + (type.unit.empty() ? "a plain number" : "in " + type.unit) +
                 ", but it is compared with " + in_unit(number->si, number->unit),
             type.unit.empty() ? "omit the unit" : "give it in " + type.unit);
}

/// Checks that signals are recorded.
class RecordedSignals {
 public:
  RecordedSignals(const SceneSpec& scene, const NodeTable& table, ErrorList& errors)
      : scene_(scene), names_(recorded_names(scene, table)), errors_(errors) {}

  /// `measure`: what needs the signal, if the scene does not name it there.
  void check(const std::string& signal, const Source& at, const std::string& measure = {}) const {
    if (may_have_more(scene_, signal) || is_recorded(signal, names_)) return;
    auto names = names_;  // with "instrument.hit" for its first output
    for (const auto& name : names_)
      if (name.find('.') != name.rfind('.')) names.push_back(name.substr(0, name.rfind('.')));
    errors_.add(Errc::UnknownName, at,
                measure.empty() ? "no signal '" + signal + "' is recorded"
                                : "'" + measure + "' needs '" + signal + "', but no such signal is recorded",
                suggest(signal, names, "recorded are " + listed(names_)));
  }
  /// The same of the signal with a role.
  void check_role(const std::string& signal, const Source& at, const std::string& role,
                  const std::string& needed_by) const {
    if (!signal.empty()) return check(signal, at, needed_by);
    const bool unknown = std::ranges::any_of(
        scene_.parts, [](const ScenePart& part) { return part.graph == nullptr || part.graph->incomplete; });
    if (!unknown && !scene_.incomplete)
      errors_.add(Errc::Missing, at, "'" + needed_by + "' needs a signal with the role '" + role + "'",
                  "give one under [roles], as in " + role + " = \"plant." + role + "\"");
  }
  std::string example() const { return names_.empty() ? "part.output" : names_.back(); }

 private:
  const SceneSpec& scene_;
  std::vector<std::string> names_;
  ErrorList& errors_;
};

void check_port(const Expectation& expectation, const SceneSpec& scene, ErrorList& errors) {
  if (scene.port(expectation.of) != nullptr) return;
  const auto names = names_of(scene.ports);
  errors.add(Errc::UnknownName, expectation.of_at, "there is no port '" + expectation.of + "'",
             suggest(expectation.of, names,
                     names.empty() ? "declare it under [ports]" : "there are " + listed(names)));
}

void check_subject(const Expectation& expectation, const Measure& type, const SceneSpec& scene,
                   const RecordedSignals& recorded, ErrorList& errors) {
  if (!expectation.of.empty() && type.subject == Measure::Subject::Port)
    check_port(expectation, scene, errors);
  else if (!expectation.of.empty())
    recorded.check(expectation.of, expectation.of_at);
  else if (type.of.empty())
    errors.add(Errc::Missing, expectation.at, "'" + expectation.measure + "' needs an 'of'",
               "give a signal, as in of = \"" + recorded.example() + "\"");
  else
    recorded.check_role(signal_of(scene.roles, type.of), expectation.at, type.of, type.name);
  if (!type.beside.empty())
    recorded.check_role(signal_of(scene.roles, type.beside), expectation.at, type.beside, type.name);
}

void check_expectation(const Expectation& expectation, const SceneSpec& scene,
                       const RecordedSignals& recorded, ErrorList& errors) {
  const auto* type = find_measure(expectation.measure);
  if (type == nullptr) return;  // reported when the scene was read
  for (const auto& limit : {expectation.min, expectation.max}) check_unit(limit, expectation, *type, errors);
  if (type->subject == Measure::Subject::Nothing) return;
  if (type->subject != Measure::Subject::Playing)
    return check_subject(expectation, *type, scene, recorded, errors);
  if (!scene.playability && !scene.incomplete)
    errors.add(Errc::Missing, expectation.at, "'" + expectation.measure + "' needs [playability]",
               "add a [playability] section with kind = \"roll\" or kind = \"tone\"");
}

void check_control_roles(const SceneSpec& scene, ErrorList& errors) {
  const auto names = control_names(scene);
  for (const auto& role : scene.control_roles)
    if (!may_have_more(scene, role.signal) && !may_have_more(scene, "instrument") &&
        !find_control(scene, role.signal))
      errors.add(Errc::UnknownName, role.at, "no part has a control '" + role.signal + "'",
                 suggest(role.signal, names, names.empty() ? "remove this line" : ""));
}

void check_signals(const SceneSpec& scene, const NodeTable& table, ErrorList& errors) {
  const RecordedSignals recorded{scene, table, errors};
  for (const auto& role : scene.roles)
    if (role.written) recorded.check(role.signal, role.at);
  check_control_roles(scene, errors);
  for (const auto& expectation : scene.expect) check_expectation(expectation, scene, recorded, errors);
  for (const auto& accuracy : scene.accuracy) {
    const auto* type = find_measure(accuracy.measure);
    if (type == nullptr || accuracy.of.empty()) continue;  // reported when the scene was read
    recorded.check(accuracy.of, accuracy.of_at);
    for (const auto& number : {accuracy.exact, accuracy.scale}) check_unit(number, accuracy, *type, errors);
  }
  if (!scene.playability) return;
  const auto check = [&](const Playability::Signal& signal, const char* role) {
    recorded.check_role(signal.name, signal.at, role, "[playability]");
  };
  const auto& playability = *scene.playability;
  if (playability.kind == Playability::Kind::Roll) {
    check(playability.hits, "hit");
    check(playability.contact, "contact");
  } else {
    check(playability.sound, "monitor");
    if (!playability.pitch.name.empty()) recorded.check(playability.pitch.name, playability.pitch.at);
  }
}

/// All outputs of the parts around the instrument.
std::vector<std::string> outputs_around(const SceneSpec& scene) {
  std::vector<std::string> names;
  for (const auto& part : scene.parts)
    if (part.name != "instrument" && part.graph != nullptr)
      for (const auto& output : part.graph->outputs) names.push_back(part.name + "." + output.name);
  return names;
}

/// The unit of an output; nothing, and an error where that is certain, if there is none of that name.
std::optional<Dimension> dimension_of(const SceneSpec& scene, const std::string& signal, const Source& at,
                                      ErrorList& errors) {
  if (signal.empty()) return std::nullopt;
  const auto dot = signal.find('.');
  const auto* part = scene.part(signal.substr(0, dot));
  if (scene.incomplete || (part != nullptr && (part->graph == nullptr || part->graph->incomplete)))
    return std::nullopt;
  const bool around = part != nullptr && part->name != "instrument" && dot != std::string::npos;
  const auto* output = around ? find_named(part->graph->outputs, signal.substr(dot + 1)) : nullptr;
  if (output == nullptr) {
    errors.add(Errc::UnknownName, at, "no part other than the instrument has an output '" + signal + "'",
               suggest(signal, outputs_around(scene)));
    return std::nullopt;
  }
  const auto* unit = find(output->fields, "unit");
  if (unit == nullptr) return Dimension{};
  const auto parsed = unit->text() == nullptr ? std::nullopt : parse_unit(*unit->text());
  return parsed ? std::optional{parsed->dimension} : std::nullopt;
}

void check_ports(const SceneSpec& scene, ErrorList& errors) {
  for (const auto& port : scene.ports) {
    const auto force = dimension_of(scene, port.force, port.force_at, errors);
    const auto position = dimension_of(scene, port.position, port.position_at, errors);
    if (force && position && !(*force * *position == parse_unit("J")->dimension))
      errors.add(Errc::UnitMismatch, port.at,
                 "'" + port.force + "' times a change of '" + port.position + "' is not an energy",
                 "give a force in N and a position in m, or a torque in N m and an angle");
  }
}

void check_drives(const SceneSpec& scene, ErrorList& errors) {
  const auto* instrument = scene.part("instrument");
  if (instrument == nullptr || instrument->graph == nullptr || instrument->graph->incomplete) return;
  std::vector<std::string> names;
  for (const auto& output : instrument->graph->outputs)
    if (output.use != OutputUse::Audio) names.push_back(output.name);
  for (const auto& [name, at] : scene.drive_places)
    if (std::ranges::find(names, name) == names.end())
      errors.add(Errc::UnknownName, at, "the instrument has no drive '" + name + "'",
                 suggest(name, names, names.empty() ? "it has none" : "it has " + listed(names)));
}

void check_comparison(const SceneSpec& scene, const std::string& name, double value, const Source& at,
                      ErrorList& errors) {
  const auto dot = name.find('.');
  const auto owner = dot == std::string::npos ? "instrument" : name.substr(0, dot);
  const auto port = dot == std::string::npos ? name : name.substr(dot + 1);
  const auto* part = scene.part(owner);
  if (part == nullptr && !scene.incomplete)
    errors.add(Errc::UnknownName, at, "there is no part '" + owner + "'", "see [parts]");
  if (part == nullptr || part->graph == nullptr || part->graph->incomplete) return;
  if (const auto* control = find_named(part->graph->controls, port)) {
    if (control->unit_known) check_range(control->control, value, at, errors);
    return;
  }
  auto known = names_of(part->graph->controls);
  if (owner != "instrument")
    for (const auto& input : part->graph->inputs) known.push_back(input.name);
  if (std::ranges::find(known, port) == known.end())
    errors.add(Errc::UnknownName, at, "part '" + owner + "' has no control '" + port + "'",
               suggest(port, known));
}

}  // namespace

void check_scene(const SceneSpec& scene, const NodeTable& table, ErrorList& errors) {
  check_signals(scene, table, errors);
  check_drives(scene, errors);
  check_ports(scene, errors);
  if (scene.compare)
    for (const auto& [name, at] : scene.compare->places)
      check_comparison(scene, name, scene.compare->set.at(name), at, errors);
}

void check_expected_pitch(const SceneSpec& scene, const std::vector<SceneTap>& taps, ErrorList& errors) {
  if (!scene.playability) return;
  const auto& pitch = scene.playability->pitch;
  static const auto kHertz = parse_unit("Hz")->dimension;
  for (const auto& tap : taps)
    if (tap.name == pitch.name && !(tap.dimension == kHertz))
      errors.add(Errc::UnitMismatch, pitch.at,
                 "'" + pitch.name + "' is " +
                     (tap.dimension.plain() ? "a plain number" : "in " + to_string(tap.dimension)) +
                     ", but 'pitch' is in Hz",
                 "give an output in Hz, or give it a unit in its part");
}

}  // namespace tactus
