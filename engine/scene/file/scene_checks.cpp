#include "engine/scene/file/scene_checks.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/named.h"
#include "engine/core/port_name.h"
#include "engine/graph/file/read_graph.h"
#include "engine/scene/measures/measure.h"

namespace tactus {
namespace {

/// A part that cannot be read may have anything.
bool is_unknown(const ScenePart& part) { return part.graph == nullptr || part.graph->incomplete; }

/// What the sections of a scene name.
class SceneChecker {
 public:
  SceneChecker(const SceneSpec& scene, const NodeTable& table, ErrorList& errors)
      : scene_(scene), errors_(errors) {
    for (const auto& part : scene.parts) {
      if (part.graph == nullptr) continue;
      const auto add = [&](const std::vector<std::string>& names) {
        for (const auto& name : names) recorded_.push_back(part.name + "." + name);
      };
      if (part.name == "instrument") {
        add(names_of(part.graph->inputs));
        add(event_taps(*part.graph, table));
      }
      add(names_of(part.graph->outputs));
    }
  }

  void check() {
    for (const auto& role : scene_.roles)
      if (role.written) check_signal(role.signal, role.at);
    check_control_roles();
    for (const auto& expectation : scene_.expect) check_expectation(expectation);
    for (const auto& accuracy : scene_.accuracy) check_accuracy(accuracy);
    if (scene_.playability) check_playability(*scene_.playability);
    check_drives();
    for (const auto& port : scene_.ports) check_port(port);
    if (scene_.compare)
      for (const auto& [name, at] : scene_.compare->places)
        check_compared(name, scene_.compare->set.at(name), at);
  }

 private:
  bool may_have_more(const std::string& signal) const {
    const auto* part = scene_.part(signal.substr(0, signal.find('.')));
    return scene_.incomplete || (part != nullptr && is_unknown(*part));
  }

  /// "plant.string[2]" is a lane of "plant.string", and "instrument.hit" the first output of that node.
  /// `measure`: what needs the signal, if the scene does not name it there.
  void check_signal(const std::string& signal, const Source& at, const std::string& measure = {}) {
    const auto whole = port_of(signal);
    const auto is_meant = [&](const std::string& name) {
      return name == whole || name.starts_with(whole + ".");
    };
    if (may_have_more(signal) || std::ranges::any_of(recorded_, is_meant)) return;
    auto names = recorded_;  // with "instrument.hit" for its first output
    for (const auto& name : recorded_)
      if (name.find('.') != name.rfind('.')) names.push_back(name.substr(0, name.rfind('.')));
    errors_.add(Errc::UnknownName, at,
                measure.empty() ? "no signal '" + signal + "' is recorded"
                                : "'" + measure + "' needs '" + signal + "', but no such signal is recorded",
                suggest(signal, names,
                        recorded_.empty() ? "nothing is recorded until the errors above are fixed"
                                          : "recorded are " + listed(recorded_)));
  }

  void check_role(const SignalName& signal, const std::string& role, const std::string& needed_by) {
    if (!signal.name.empty()) return check_signal(signal.name, signal.at, needed_by);
    if (!scene_.incomplete && std::ranges::none_of(scene_.parts, is_unknown))
      errors_.add(Errc::Missing, signal.at, "'" + needed_by + "' needs a signal with the role '" + role + "'",
                  "give one under [roles], as in " + role + " = \"plant." + role + "\"");
  }

  void check_control_roles() {
    const auto names = control_names(scene_);
    for (const auto& role : scene_.control_roles)
      if (!may_have_more(role.signal) && !may_have_more("instrument") && !find_control(scene_, role.signal))
        errors_.add(Errc::UnknownName, role.at, "no part has a control '" + role.signal + "'",
                    suggest(role.signal, names, names.empty() ? "remove this line" : ""));
  }

  /// A number of [expect] or [accuracy] beside the measure that it is a value of.
  void check_unit(const std::optional<QuantityValue>& number, const MeasureEntry& entry,
                  const Measure& type) {
    if (!number || number->bare || type.unit == Measure::kUnitOfSubject) return;
    if (number->unit.dimension == parse_unit(type.unit)->dimension) return;
    errors_.add(Errc::UnitMismatch, entry.at,
                "'" + entry.measure + "' is " + (type.unit.empty() ? "a plain number" : "in " + type.unit) +
                    ", but it is compared with " + in_unit(number->si, number->unit),
                type.unit.empty() ? "omit the unit" : "give it in " + type.unit);
  }

  void check_expectation(const Expectation& expectation) {
    using enum Measure::Subject;
    const auto* type = find_measure(expectation.measure);
    if (type == nullptr) return;  // reported when the scene was read
    for (const auto& limit : {expectation.min, expectation.max}) check_unit(limit, expectation, *type);
    if (type->subject == Playing && !scene_.playability && !scene_.incomplete)
      errors_.add(Errc::Missing, expectation.at, "'" + expectation.measure + "' needs [playability]",
                  "add a [playability] section with kind = \"roll\" or kind = \"tone\"");
    if (type->subject != Nothing && type->subject != Playing) check_subject(expectation, *type);
  }

  void check_subject(const Expectation& expectation, const Measure& type) {
    const auto& [of, at] = std::tie(expectation.of, expectation.of_at);
    const auto check_role_of = [&](const std::string& role) {
      check_role({signal_of(scene_.roles, role), expectation.at}, role, type.name);
    };
    if (!of.empty() && type.subject != Measure::Subject::Port)
      check_signal(of, at);
    else if (!of.empty() && scene_.port(of) == nullptr)
      errors_.add(
          Errc::UnknownName, at, "there is no port '" + of + "'",
          suggest(of, names_of(scene_.ports), scene_.ports.empty() ? "declare it under [ports]" : ""));
    else if (of.empty() && type.of.empty())
      errors_.add(
          Errc::Missing, expectation.at, "'" + expectation.measure + "' needs an 'of'",
          "give a signal, as in of = \"" + (recorded_.empty() ? "part.output" : recorded_.back()) + "\"");
    else if (of.empty())
      check_role_of(type.of);
    if (!type.beside.empty()) check_role_of(type.beside);
  }

  void check_accuracy(const Accuracy& accuracy) {
    const auto* type = find_measure(accuracy.measure);
    if (type == nullptr || accuracy.of.empty()) return;  // reported when the scene was read
    check_signal(accuracy.of, accuracy.of_at);
    for (const auto& number : {accuracy.exact, accuracy.scale}) check_unit(number, accuracy, *type);
  }

  void check_playability(const Playability& playability) {
    constexpr const char* kSection = "[playability]";
    if (playability.kind == Playability::Kind::Roll) {
      check_role(playability.hits, "hit", kSection);
      check_role(playability.contact, "contact", kSection);
    } else {
      check_role(playability.sound, "monitor", kSection);
      if (!playability.pitch.name.empty()) check_signal(playability.pitch.name, playability.pitch.at);
    }
  }

  /// The unit of an output; nothing, and an error where that is certain, if there is none of that name.
  std::optional<Dimension> dimension_of(const SignalName& signal) {
    if (signal.name.empty() || may_have_more(signal.name)) return std::nullopt;
    std::vector<std::string> names;
    for (const auto& part : scene_.parts) {
      if (part.name == "instrument" || part.graph == nullptr) continue;
      for (const auto& output : part.graph->outputs) {
        names.push_back(part.name + "." + output.name);
        if (names.back() == signal.name)
          return output.unit_known ? std::optional{output.dimension} : std::nullopt;
      }
    }
    errors_.add(Errc::UnknownName, signal.at,
                "no part other than the instrument has an output '" + signal.name + "'",
                suggest(signal.name, names));
    return std::nullopt;
  }

  void check_port(const Port& port) {
    const auto force = dimension_of(port.force), position = dimension_of(port.position);
    if (force && position && !(*force * *position == parse_unit("J")->dimension))
      errors_.add(Errc::UnitMismatch, port.at,
                  "'" + port.force.name + "' times a change of '" + port.position.name + "' is not an energy",
                  "give a force in N and a position in m, or a torque in N m and an angle");
  }

  void check_drives() {
    const auto* instrument = scene_.part("instrument");
    if (instrument == nullptr || is_unknown(*instrument)) return;
    std::vector<std::string> names;
    for (const auto& output : instrument->graph->outputs)
      if (output.use != OutputUse::Audio) names.push_back(output.name);
    for (const auto& [name, at] : scene_.drive_places)
      if (std::ranges::find(names, name) == names.end())
        errors_.add(Errc::UnknownName, at, "the instrument has no drive '" + name + "'",
                    suggest(name, names, names.empty() ? "it has none" : "it has " + listed(names)));
  }

  void check_compared(const std::string& name, double value, const Source& at) {
    const auto dot = name.find('.');
    const auto owner = dot == std::string::npos ? "instrument" : name.substr(0, dot);
    const auto port = dot == std::string::npos ? name : name.substr(dot + 1);
    const auto* part = scene_.part(owner);
    if (part == nullptr && !scene_.incomplete)
      errors_.add(Errc::UnknownName, at, "there is no part '" + owner + "'", "see [parts]");
    if (part == nullptr || is_unknown(*part)) return;
    if (const auto* control = find_named(part->graph->controls, port)) {
      if (control->unit_known) check_range(*control, value, at, errors_);
      return;
    }
    auto known = names_of(part->graph->controls);
    if (owner != "instrument")
      for (const auto& input : part->graph->inputs) known.push_back(input.name);
    if (std::ranges::find(known, port) == known.end())
      errors_.add(Errc::UnknownName, at, "part '" + owner + "' has no control '" + port + "'",
                  suggest(port, known));
  }

  const SceneSpec& scene_;
  std::vector<std::string> recorded_;
  ErrorList& errors_;
};

}  // namespace

void check_scene(const SceneSpec& scene, const NodeTable& table, ErrorList& errors) {
  SceneChecker{scene, table, errors}.check();
}

bool check_range(const ControlSpec& entry, double value, const Source& at, ErrorList& errors,
                 const std::string& by) {
  const auto& control = entry.control;
  const bool inside = control.range.contains(value);
  if (inside && !(takes_whole_numbers(entry) && std::floor(value) != value)) return true;
  errors.add(Errc::OutOfRange, at,
             "control '" + control.name + "' cannot be set to " + in_unit(value, control.unit) + by,
             inside ? kGiveWholeNumber : limits_text(control.range.low, control.range.high, control.unit));
  return false;
}

void check_expected_pitch(const SceneSpec& scene, const std::vector<SceneTap>& taps, ErrorList& errors) {
  if (!scene.playability) return;
  const auto& pitch = scene.playability->pitch;
  static const auto kHertz = parse_unit("Hz")->dimension;
  for (const auto& tap : taps)
    if (tap.name == pitch.name && !(tap.dimension == kHertz))
      errors.add(Errc::UnitMismatch, pitch.at,
                 "'" + pitch.name + "' is " + unit_phrase(tap.dimension) + ", but 'pitch' is in Hz",
                 "give an output in Hz, or give it a unit in its part");
}

}  // namespace tactus
