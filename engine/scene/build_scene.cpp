#include "engine/scene/build_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "engine/core/index.h"
#include "engine/core/named.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/plan/compile.h"
#include "engine/scene/file/scene_checks.h"
#include "engine/scene/guard_report.h"

namespace tactus {
namespace {

Value text_value(std::string text, const Source& at) { return {std::move(text), at}; }

Value value_of(const ControlValue& value, const Source& at) {
  if (!value.dimension || value.dimension->plain()) return {value.si, at};
  return text_value(fmt::format("{:.17g} {}", value.si, to_string(*value.dimension)), at);
}

/// Sets a field, replacing what it was.
void put(Value::Table& fields, const std::string& port, const Value& value) {
  std::erase_if(fields, [&](const Field& field) { return field.key == port; });
  fields.push_back({port, value.at, value});
}

/// A gesture as a node of the graph around the instrument.
NodeSpec gesture_node(const Gesture& gesture) {
  const auto& at = gesture.at;
  NodeSpec node{{gesture.name, at, {}, gesture.points.empty()}, "curve", {}, {}, at};
  Value::List points;
  for (const auto& point : gesture.points)
    points.push_back({Value::List{{point.time_s, at}, {point.value, at}}, at});
  node.fields.push_back({"points", at, {std::move(points), at}});
  const auto& curves = (*scene_fields()["gestures"].inside)["curve"].choices;
  node.fields.push_back({"curve", at, text_value(curves[static_cast<std::size_t>(gesture.curve)], at)});
  if (!gesture.bare) node.fields.push_back({"unit", at, text_value(to_string(gesture.unit.dimension), at)});
  return node;
}

/// A control of the instrument that a gesture moves.
struct MovedControl {
  std::string control;
  const Gesture* gesture;
  Source at;
};

/// Of a gesture over a long time, points a millisecond apart would be too many to keep.
double step_of(const std::vector<Gesture::Point>& points) {
  constexpr double kMaxSteps = 1e6;
  return std::max(1e-3, (points.back().time_s - points.front().time_s) / kMaxSteps);
}

void add_slope(const Gesture::Point& from, const Gesture::Point& to, Gesture::Curve curve, double step_s,
               const auto& add) {
  for (double t = from.time_s + step_s; t < to.time_s; t += step_s) {
    double u = (t - from.time_s) / (to.time_s - from.time_s);
    if (curve == Gesture::Curve::Smooth) u = u * u * (3 - 2 * u);
    add(t, from.value + (to.value - from.value) * u);
  }
}

/// The gestures as changes of controls, in order of time: a step becomes an entry at its frame; a slope
/// becomes one a millisecond (at most 1000000 in all), which the control's own smoothing joins.
std::vector<JournalEntry> gesture_journal(const std::vector<MovedControl>& moved, const Plan& plan) {
  std::vector<JournalEntry> entries;
  for (const auto& [control, gesture, at] : moved) {
    const int index = plan.control_index(control);
    const auto add = [&](double time_s, double value) {
      entries.push_back(
          {std::lround(time_s * plan.sample_rate.value), JournalEntry::Kind::ControlChange, index, value});
    };
    const auto& points = gesture->points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      add(points[i].time_s, points[i].value);
      if (gesture->curve != Gesture::Curve::Step && i + 1 < points.size())
        add_slope(points[i], points[i + 1], gesture->curve, step_of(points), add);
    }
  }
  std::ranges::stable_sort(entries, {}, &JournalEntry::frame);
  return entries;
}

std::vector<SceneTap> taps_of(const Plan& plan, const std::string& prefix) {
  std::vector<SceneTap> taps;
  for (const auto& channel : plan.channels)
    if (channel.use == OutputUse::Tap) taps.push_back({prefix + channel.name, channel.dimension});
  return taps;
}

class SceneBuilder {
 public:
  SceneBuilder(const LoadedScene& loaded, const NodeTable& table, const SceneOptions& options)
      : scene_(*loaded.scene), table_(table), options_(options), errors_(scene_.file) {
    errors_.add(loaded.errors);
  }

  Checked<CompiledScene> run() {
    built_.delay_frames = static_cast<int>(std::lround(frames_in(delay_, rate_)));
    // The ring holds whole frames; the instrument compensates for exactly these.
    delay_ = Seconds{built_.delay_frames / rate_.value};
    route_set();
    make_world();
    if (instrument_known()) wire_instrument();
    check_scene(scene_, table_, errors_);
    if (instrument_known() || has_no_instrument()) compile_instrument();
    declare_drives();
    compile_world();
    if (built_.plant != nullptr && built_.instrument != nullptr) {
      check_channels();
      check_size();
    }
    if (errors_.any()) return tl::unexpected(errors_.take());
    return std::move(built_);
  }

 private:
  /// A scene of a plant alone.
  bool has_no_instrument() const { return instrument_ == nullptr && !scene_.incomplete; }
  bool instrument_known() const { return instrument_ != nullptr && instrument_->graph != nullptr; }

  /// "strength" is the instrument's, and no gesture moves it then; "plant.gain" overwrites a wire of a part.
  void route_set() {
    for (const auto& [name, value] : options_.set) {
      const auto dot = name.find('.');
      if (dot == std::string::npos)
        controls_[name] = value;
      else if (name.substr(0, dot) == "instrument")
        controls_[name.substr(dot + 1)] = value;
      else
        overwritten_[name.substr(0, dot)][name.substr(dot + 1)] = value;
    }
  }

  // ---- the world: one graph of all parts but the instrument

  void make_world() {
    world_.file = scene_.file;
    world_.name = scene_.name;
    world_.incomplete = scene_.incomplete;
    for (const auto& gesture : scene_.gestures) world_.nodes.push_back(gesture_node(gesture));
    for (const auto& part : scene_.parts) {
      if (part.name == "instrument") continue;
      NodeSpec node{{part.name, part.at, part.wires, part.graph == nullptr}, {}, part.name, {}, {}};
      for (const auto& [port, value] : overwritten_[part.name])
        put(node.fields, port, value_of(value, part.at));
      if (options_.by_hand && part.graph != nullptr) strike_by_hand(*part.graph, node);
      world_.nodes.push_back(std::move(node));
      if (part.graph == nullptr) continue;
      world_.parts[part.name] = part.graph;
      for (const auto& output : part.graph->outputs) taps_.push_back(part.name + "." + output.name);
    }
    for (const auto& [name, fields] : overwritten_)
      if (!fields.empty() && scene_.part(name) == nullptr)
        errors_.add(Errc::UnknownName, scene_.file,
                    "there is no part '" + name + "' to set '" + fields.begin()->first + "' of",
                    "see [parts] of the scene");
  }

  /// Where the part has a control of this name, its `node` follows one of the world, from 0 to 1.
  void strike_by_hand(const GraphSpec& part, NodeSpec& node) {
    constexpr const char* kStrike = "strike";
    if (find_named(part.controls, kStrike) == nullptr) return;
    if (find_named(world_.controls, kStrike) == nullptr)
      world_.controls.push_back({{kStrike, node.at, {}}, {.name = kStrike, .range = {0, 1}, .smooth_s = 0}});
    put(node.fields, kStrike, text_value(kStrike, node.at));
  }

  /// The instrument's outputs are inputs of the plant, with as many lanes.
  void declare_drives() {
    if (has_no_instrument()) return;
    if (!instrument_known() || instrument_->graph->incomplete)
      return world_.nodes.push_back({{"instrument", {}, {}, true}, {}, {}, {}, {}});
    for (const auto& output : instrument_->graph->outputs) {
      world_.inputs.push_back({{"instrument." + output.name, output.at, {}}});
      if (built_.instrument != nullptr) world_.inputs.back().lanes = lanes_of(*built_.instrument, output);
    }
  }

  static int lanes_of(const Plan& instrument, const PortSpec& output) {
    return static_cast<int>(std::ranges::count_if(output_names(instrument), [&](const std::string& lane) {
      return lane == output.name || lane.starts_with(output.name + "[");
    }));
  }

  void wire_instrument() {
    const auto& graph = *instrument_->graph;
    for (const auto& input : graph.inputs) {
      const auto* wire = find(instrument_->wires, input.name);
      if (wire == nullptr) {
        errors_.add(Errc::Missing, instrument_->at,
                    "input '" + input.name + "' of the instrument is not connected",
                    "give its source, as in " + input.name + " = \"plant." + input.name + "\"");
        continue;
      }
      PortSpec output{{"instrument." + input.name, wire->at, {{"from", wire->at, *wire}}}};
      output.dimension = input.dimension;
      output.unit_known = input.unit_known;
      world_.outputs.push_back(std::move(output));
    }
    auto settable = names_of(graph.inputs);
    for (const auto& control : graph.controls) settable.push_back(control.name);
    for (const auto& field : instrument_->wires) {
      if (find_named(graph.inputs, field.key) != nullptr) continue;
      if (const auto* control = find_named(graph.controls, field.key))
        wire_control(*control, field);
      else if (!graph.incomplete)
        errors_.add(Errc::UnknownName, field.at, "the instrument has no input or control '" + field.key + "'",
                    suggest(field.key, settable, "see its [inputs] and [controls]"));
    }
  }

  /// A control of the instrument has an initial value, and a gesture may move it.
  void wire_control(const ControlSpec& entry, const Field& field) {
    if (entry.broken) return;
    const auto* text = field.value.text();
    const auto* gesture = text != nullptr ? scene_.gesture(*text) : nullptr;
    if (gesture != nullptr && gesture->points.empty()) return;
    if (gesture != nullptr && entry.unit_known) check_gesture(*gesture, entry, field.value.at);
    const auto start = gesture != nullptr ? gesture->points.front().value : start_of(entry, field.value);
    if (!start) return;
    const bool asked = !controls_.try_emplace(entry.name, *start).second;
    if (gesture != nullptr && !asked) moved_.push_back({entry.name, gesture, field.value.at});
  }

  std::optional<double> start_of(const ControlSpec& entry, const Value& value) {
    const auto& control = entry.control;
    const auto* text = value.text();
    if (text != nullptr && !parse_quantity(*text)) {
      if (!scene_.incomplete)
        errors_.add(Errc::WrongType, value.at,
                    "'" + *text + "' is neither a value for control '" + control.name + "' nor a gesture",
                    "give a number or a quantity, or the name of a gesture");
      return std::nullopt;
    }
    if (!entry.unit_known) return std::nullopt;
    const auto start = read_quantity(value, control.unit, control.name);
    const bool good = errors_.keep(start) != nullptr && check_range(entry, *start, value.at, errors_);
    return good ? std::optional{*start} : std::nullopt;
  }

  void check_gesture(const Gesture& gesture, const ControlSpec& entry, const Source& at) {
    const auto& control = entry.control;
    if (!gesture.bare && !(gesture.unit.dimension == control.unit.dimension))
      return errors_.add(Errc::UnitMismatch, at,
                         "control '" + control.name + "' is " + unit_phrase(control.unit.dimension) +
                             ", but gesture '" + gesture.name + "' is " + unit_phrase(gesture.unit.dimension),
                         "write the points of the gesture in the unit of the control");
    for (const auto& point : gesture.points)
      if (!check_range(entry, point.value, at, errors_, " by gesture '" + gesture.name + "'")) return;
  }

  // ---- compiling

  /// Makes nodes only if there is no error; nullptr and errors otherwise.
  std::unique_ptr<Plan> compile_or_check(const GraphSpec& graph, const CompileOptions& options) {
    if (errors_.any()) {
      errors_.add(check(graph, table_, options));
      return nullptr;
    }
    auto compiled = compile(graph, table_, options);
    if (compiled) return std::move(*compiled);
    errors_.add(std::move(compiled.error()));
    return nullptr;
  }

  CompileOptions compile_options(std::vector<std::string> taps) const {
    return {.sample_rate = rate_,
            .system_delay = delay_,
            .controls = {},
            .taps = std::move(taps),
            .vectorise = options_.vectorise};
  }

  void compile_world() {
    auto options = compile_options(taps_);
    options.closed_outside = built_.delay_frames == 0;
    auto compiled = compile_or_check(world_, options);
    if (compiled == nullptr) return;
    built_.plant_taps = taps_of(*compiled, "");
    check_expected_pitch(scene_, built_.plant_taps, errors_);
    // To the compiler a gesture is a node, which a control, a measure or a plot may take all the same;
    // nothing else of the scene's own file can be unused. No user writes the files of a test bench.
    const auto unused = [&](const Gesture& gesture) {
      return std::ranges::any_of(compiled->warnings,
                                 [&](const Error& warning) {
                                   return warning.code == Errc::UnknownName &&
                                          warning.where == gesture.at.text();
                                 }) &&
             !taken(gesture.name);
    };
    std::vector<Error> of_gestures;
    for (const auto& gesture : scene_.gestures)
      if (!scene_.bench && options_.set.empty() && unused(gesture))
        of_gestures.push_back({Errc::UnknownName, gesture.at.text(),
                               "gesture '" + gesture.name + "' is not used",
                               "connect it to an input or a control of a part, or remove it"});
    std::erase_if(compiled->warnings, [this](const Error& warning) {
      return scene_.bench ||
             (warning.code == Errc::UnknownName && warning.where.starts_with(*world_.file.file + ":"));
    });
    std::ranges::move(of_gestures, std::back_inserter(compiled->warnings));
    built_.plant = std::move(compiled);
  }

  /// Whether a control of the instrument, a measure or a role takes a gesture.
  bool taken(const std::string& gesture) const {
    const auto is_it = [&](const std::string& signal) { return signal == gesture; };
    const auto& judged = scene_.playability;
    return std::ranges::any_of(moved_, is_it,
                               [](const MovedControl& moved) { return moved.gesture->name; }) ||
           std::ranges::any_of(scene_.roles, is_it, &Role::signal) ||
           std::ranges::any_of(scene_.expect, is_it, &Expectation::of) ||
           std::ranges::any_of(scene_.accuracy, is_it, &Accuracy::of) ||
           (judged && (is_it(judged->pitch.name) || is_it(judged->sound.name)));
  }

  /// All that is recorded must fit into memory.
  void check_size() {
    constexpr double kMaxSamples = 1u << 29;
    const auto signals =
        static_cast<double>(built_.plant->channels.size() + built_.instrument->channels.size());
    const double samples = signals * frames_in(scene_.duration, rate_);
    if (samples > kMaxSamples)
      errors_.add(Errc::OutOfRange, scene_.duration_at,
                  "to record " + short_number(signals) + " signals for " +
                      short_quantity(scene_.duration.value, Dimension{.second = 1}) + " takes " +
                      short_number(std::ceil(samples * sizeof(double) / 1e9)) + " GB, more than 4",
                  "shorten 'duration'");
  }

  /// Signals between the two engines have one lane each, or the channels would shift.
  void check_channels() {
    const auto check = [this](const Plan& from, const Plan& to, const char* what) {
      const auto lanes = output_names(from).size(), wired = to.input_names.size();
      if (lanes != wired)
        errors_.add(Errc::OutOfRange, instrument_ != nullptr ? instrument_->at : scene_.file,
                    fmt::format("{} have {} lanes, but {} are connected", what, lanes, wired),
                    "in a scene, give each lane its own input or output, or 'mix' them");
    };
    check(*built_.plant, *built_.instrument, "the connections to the instrument");
    check(*built_.instrument, *built_.plant, "the instrument's outputs");
  }

  void compile_instrument() {
    GraphSpec nothing;
    nothing.file = scene_.file;
    const auto& graph = has_no_instrument() ? nothing : *instrument_->graph;
    auto options = compile_options(event_taps(graph, table_));
    options.controls = controls_;
    auto compiled = compile_or_check(graph, options);
    if (compiled == nullptr) return;
    built_.instrument_taps = taps_of(*compiled, "instrument.");
    check_moved(*compiled);
    built_.journal = gesture_journal(moved_, *compiled);
    built_.instrument = std::move(compiled);
  }

  /// A control that something was made with keeps its value.
  void check_moved(const Plan& plan) {
    for (const auto& [control, gesture, at] : moved_) {
      const int found = plan.control_index(control);
      const auto differs = [&](const Gesture::Point& point) {
        return point.value != gesture->points.front().value;
      };
      if (found >= 0 && plan.controls[index(found)].frozen && std::ranges::any_of(gesture->points, differs))
        errors_.add(Errc::WrongType, at,
                    "a gesture cannot move control '" + control +
                        "', because a number that does not change during playback is computed from it",
                    "give it a number, or use the control where signals are allowed");
    }
  }

  const SceneSpec& scene_;
  const NodeTable& table_;
  const SceneOptions& options_;
  const ScenePart* instrument_ = scene_.part("instrument");
  Hertz rate_ = options_.rate.value_or(scene_.rate);
  Seconds delay_ = options_.delay.value_or(scene_.delay);
  GraphSpec world_;
  std::vector<std::string> taps_;
  std::map<std::string, ControlValue> controls_;
  std::map<std::string, std::map<std::string, ControlValue>> overwritten_;
  std::vector<MovedControl> moved_;
  ErrorList errors_;
  CompiledScene built_;
};

}  // namespace

Checked<CompiledScene> compile_scene(const LoadedScene& loaded, const NodeTable& table,
                                     const SceneOptions& options) {
  if (!loaded.scene) return tl::unexpected(loaded.errors);
  return SceneBuilder{loaded, table, options}.run();
}

BuiltScene::BuiltScene(CompiledScene compiled)
    : SceneTaps(compiled),
      instrument(std::make_unique<Player>(std::move(compiled.instrument))),
      plant(std::make_unique<Player>(std::move(compiled.plant))) {
  instrument->set_journal(std::move(compiled.journal));
}

Checked<BuiltScene> build_scene(const LoadedScene& loaded, const NodeTable& table,
                                const SceneOptions& options) {
  return compile_scene(loaded, table, options).map([](CompiledScene made) {
    return BuiltScene{std::move(made)};
  });
}

std::vector<std::string> event_taps(const GraphSpec& graph, const NodeTable& table) {
  std::vector<std::string> taps;
  for (const auto& node : graph.nodes) {
    const auto* type = table.find(node.type);
    if (type == nullptr) continue;
    for (const auto& output : type->outputs)
      if (output.kind == OutputKind::Trigger || output.event_level)
        taps.push_back(node.name + "." + output.name);
  }
  for (const auto& network : graph.networks) {
    const auto type = network.world ? table.network(network) : Checked<std::shared_ptr<const NodeType>>{};
    if (!type || *type == nullptr) continue;
    for (const auto& output : (*type)->outputs)
      if ((output.kind == OutputKind::Trigger || output.event_level) &&
          output.name.find('.') != std::string::npos)
        taps.push_back(network.name + "." + output.name);
  }
  return taps;
}

}  // namespace tactus
