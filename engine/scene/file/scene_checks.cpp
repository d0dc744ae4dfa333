#include "engine/scene/file/scene_checks.h"

#include <algorithm>
#include <string>

#include "engine/graph/file/read_graph.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/file/roles.h"
#include "engine/scene/measures/measure.h"
#include "engine/scene/moved_controls.h"

namespace tactus {
namespace {

std::vector<std::string> names_of(const std::vector<EntrySpec>& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries) names.push_back(entry.name);
  return names;
}

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
  return std::any_of(recorded.begin(), recorded.end(), [&](const std::string& known) {
    return known == whole || known.starts_with(whole + ".");
  });
}

/// A part that cannot be read may have anything.
bool may_have_more(const SceneSpec& scene, const std::string& name) {
  const auto* part = scene.part(name.substr(0, name.find('.')));
  return scene.incomplete || (part != nullptr && (part->graph == nullptr || part->graph->incomplete));
}

void complain_unknown(const Expectation& expectation, ErrorList& mistakes) {
  const auto names = value_names();
  mistakes.add(Errc::UnknownName, expectation.measure_at, "there is no measure '" + expectation.measure + "'",
               suggest(expectation.measure, names));
}

void check_limits(const Expectation& expectation, const Measure& type, ErrorList& mistakes) {
  if (type.unit == Measure::kUnitOfSubject) return;
  for (const auto& limit : {expectation.min, expectation.max})
    if (limit && !limit->bare && !(limit->unit.dimension == parse_unit(type.unit)->dimension))
      mistakes.add(Errc::UnitMismatch, expectation.at,
                   "'" + expectation.measure + "' is " +
                       (type.unit.empty() ? "a plain number" : "in " + type.unit) +
                       ", but it is to be compared with " + in_unit(limit->si, limit->unit),
                   type.unit.empty() ? "leave the unit out" : "give its limits in " + type.unit);
}

void check_subject(const Expectation& expectation, const std::string& of, const SceneSpec& scene,
                   const std::vector<std::string>& recorded, ErrorList& mistakes) {
  if (may_have_more(scene, of) || is_recorded(of, recorded)) return;
  auto names = recorded;  // with "instrument.hit" for its first output
  for (const auto& name : recorded)
    if (name.find('.') != name.rfind('.')) names.push_back(name.substr(0, name.rfind('.')));
  mistakes.add(Errc::UnknownName, expectation.of_at,
               of == expectation.of
                   ? "nothing called '" + of + "' is recorded"
                   : "'" + expectation.measure + "' needs '" + of + "', and nothing of that name is recorded",
               suggest(of, names, "recorded are " + listed(recorded)));
}

void check_recorded(const std::string& of, const Source& at, const SceneSpec& scene,
                    const std::vector<std::string>& recorded, ErrorList& mistakes) {
  Expectation subject;
  subject.of = of;
  subject.of_at = at;
  check_subject(subject, of, scene, recorded, mistakes);
}

void report_role(const std::string& needed_by, const Source& at, const std::string& role,
                 const SceneSpec& scene, ErrorList& mistakes) {
  const bool unknown = std::any_of(scene.parts.begin(), scene.parts.end(), [&](const ScenePart& part) {
    return part.graph == nullptr || part.graph->incomplete;
  });
  if (unknown || scene.incomplete) return;
  mistakes.add(Errc::Missing, at, "'" + needed_by + "' needs a signal with the role '" + role + "'",
               "name one under [roles], as in " + role + " = \"plant." + role + "\"");
}

void check_port(const Expectation& expectation, const SceneSpec& scene, ErrorList& mistakes) {
  if (scene.port(expectation.of) != nullptr) return;
  std::vector<std::string> names;
  for (const auto& port : scene.ports) names.push_back(port.name);
  mistakes.add(Errc::UnknownName, expectation.of_at, "there is no port '" + expectation.of + "'",
               suggest(expectation.of, names,
                       names.empty() ? "declare it under [ports]" : "there are " + listed(names)));
}

}  // namespace

const EntrySpec* find_entry(const std::vector<EntrySpec>& entries, std::string_view name) {
  const auto it =
      std::find_if(entries.begin(), entries.end(), [&](const EntrySpec& e) { return e.name == name; });
  return it == entries.end() ? nullptr : &*it;
}

void check_measures(const SceneSpec& scene, const NodeTable& table, ErrorList& mistakes) {
  const auto recorded = recorded_names(scene, table);
  for (const auto& role : scene.roles)
    if (role.written) check_recorded(role.signal, role.at, scene, recorded, mistakes);
  for (const auto& expectation : scene.expect) {
    if (expectation.measure.empty()) continue;  // reported when the scene was read
    const auto* type = find_measure(expectation.measure);
    if (type == nullptr || type->value == nullptr) {
      complain_unknown(expectation, mistakes);
      continue;
    }
    check_limits(expectation, *type, mistakes);
    if (type->subject == Measure::Subject::Nothing) continue;
    if (type->subject == Measure::Subject::Playing) {
      if (!scene.playability && !scene.incomplete)
        mistakes.add(Errc::Missing, expectation.at, "'" + expectation.measure + "' needs [playability]",
                     "add the section with kind = \"roll\" or kind = \"tone\"");
      continue;
    }
    const auto of = expectation.of.empty() ? signal_of(scene.roles, type->of) : expectation.of;
    if (of.empty() && !type->of.empty())
      report_role(expectation.measure, expectation.at, type->of, scene, mistakes);
    else if (of.empty())
      mistakes.add(
          Errc::Missing, expectation.at, "'" + expectation.measure + "' needs an 'of'",
          "say of what, as in of = \"" + (recorded.empty() ? "part.output" : recorded.back()) + "\"");
    else if (type->subject == Measure::Subject::Port)
      check_port(expectation, scene, mistakes);
    else
      check_subject(expectation, of, scene, recorded, mistakes);
    if (type->beside.empty()) continue;
    if (const auto beside = signal_of(scene.roles, type->beside); beside.empty())
      report_role(expectation.measure, expectation.at, type->beside, scene, mistakes);
    else
      check_subject(expectation, beside, scene, recorded, mistakes);
  }
}

void check_accuracy(const SceneSpec& scene, const NodeTable& table, ErrorList& mistakes) {
  const auto recorded = recorded_names(scene, table);
  for (const auto& accuracy : scene.accuracy) {
    const auto* type = find_measure(accuracy.measure);
    if (type == nullptr || type->error == nullptr || accuracy.of.empty())
      continue;  // reported when the scene was read
    check_recorded(accuracy.of, accuracy.of_at, scene, recorded, mistakes);
    const auto check_unit = [&](const std::optional<QuantityValue>& number, const std::string& unit) {
      if (!number || number->bare || unit == Measure::kUnitOfSubject) return;
      if (!(number->unit.dimension == parse_unit(unit)->dimension))
        mistakes.add(
            Errc::UnitMismatch, accuracy.at,
            "'" + accuracy.measure + "' is in " + unit + ", not " + in_unit(number->si, number->unit),
            "give it in " + unit);
    };
    check_unit(accuracy.exact, type->unit);
    check_unit(accuracy.scale, type->unit);
  }
}

void check_playability(const SceneSpec& scene, const NodeTable& table, ErrorList& mistakes) {
  if (!scene.playability) return;
  const auto recorded = recorded_names(scene, table);
  const auto& judged = *scene.playability;
  const bool roll = judged.kind == Playability::Kind::Roll;
  auto signals = roll ? std::vector{&judged.hits, &judged.contact} : std::vector{&judged.sound};
  if (!roll && !judged.pitch.name.empty()) signals.push_back(&judged.pitch);
  for (const auto* signal : signals)
    if (signal->name.empty())
      report_role("[playability]", signal->at,
                  signal == &judged.hits ? "hit"
                  : roll                 ? "contact"
                                         : "monitor",
                  scene, mistakes);
    else
      check_recorded(signal->name, signal->at, scene, recorded, mistakes);
}

void check_expected_pitch(const SceneSpec& scene, const std::vector<SceneTap>& taps, ErrorList& mistakes) {
  if (!scene.playability) return;
  const auto& pitch = scene.playability->pitch;
  static const auto kHertz = parse_unit("Hz")->dimension;
  for (const auto& tap : taps)
    if (tap.name == pitch.name && !(tap.dimension == kHertz))
      mistakes.add(Errc::UnitMismatch, pitch.at,
                   "'" + pitch.name + "' is " +
                       (tap.dimension.plain() ? "a plain number" : "in " + to_string(tap.dimension)) +
                       ", but 'pitch' is in Hz",
                   "name an output in Hz, or give it a unit in its part");
}

void check_comparison(const SceneSpec& scene, ErrorList& mistakes) {
  if (!scene.compare) return;
  for (const auto& [name, at] : scene.compare->places) {
    const auto dot = name.find('.');
    const auto owner = dot == std::string::npos ? "instrument" : name.substr(0, dot);
    const auto port = dot == std::string::npos ? name : name.substr(dot + 1);
    const auto* part = scene.part(owner);
    if (part == nullptr && !scene.incomplete)
      mistakes.add(Errc::UnknownName, at, "there is no part '" + owner + "'", "see [parts]");
    if (part == nullptr || part->graph == nullptr || part->graph->incomplete) continue;
    auto known = names_of(part->graph->controls);
    if (owner != "instrument")
      for (const auto& input : part->graph->inputs) known.push_back(input.name);
    if (const auto* control = find_entry(part->graph->controls, port);
        control != nullptr && !control->broken) {
      ErrorList told_by_the_graph;
      const auto read = read_control(*control, told_by_the_graph);
      if (const double value = scene.compare->set.at(name);
          read.unit_known && !read.control.range.contains(value))
        complain_range(read.control, value, at, mistakes);
    }
    if (std::find(known.begin(), known.end(), port) != known.end()) continue;
    mistakes.add(Errc::UnknownName, at, "part '" + owner + "' has no control '" + port + "'",
                 suggest(port, known));
  }
}

}  // namespace tactus
