#include "engine/scene/build_scene.h"

#include <algorithm>
#include <cmath>

#include "engine/graph/compile.h"
#include "engine/graph/mistakes.h"
#include "engine/graph/nearest.h"

namespace tactus {
namespace {

Value text_value(std::string text, const Source& at) { return {std::move(text), at}; }

const EntrySpec* find_entry(const std::vector<EntrySpec>& entries, std::string_view name) {
  const auto it =
      std::find_if(entries.begin(), entries.end(), [&](const EntrySpec& e) { return e.name == name; });
  return it == entries.end() ? nullptr : &*it;
}

const char* curve_name(Gesture::Curve curve) {
  return curve == Gesture::Curve::Step ? "step" : curve == Gesture::Curve::Smooth ? "smooth" : "linear";
}

NodeSpec gesture_node(const Gesture& gesture) {
  NodeSpec node;
  node.name = gesture.name;
  node.at = gesture.at;
  node.type = "curve";
  node.type_at = gesture.at;
  Value::List points;
  for (const auto& point : gesture.points) {
    Value::List pair{{point.time_s, gesture.at}, {point.value, gesture.at}};
    points.push_back({std::move(pair), gesture.at});
  }
  node.fields.push_back({"points", gesture.at, {std::move(points), gesture.at}});
  node.fields.push_back({"curve", gesture.at, text_value(curve_name(gesture.curve), gesture.at)});
  node.fields.push_back({"unit", gesture.at, text_value(to_string(gesture.unit.dimension), gesture.at)});
  return node;
}

class SceneBuilder {
 public:
  SceneBuilder(const SceneSpec& scene, const NodeTable& table, const SceneOptions& options)
      : scene_(scene),
        table_(table),
        options_(options),
        instrument_(*scene.part("instrument")),
        rate_(options.rate.value_or(scene.rate)),
        delay_(options.delay.value_or(scene.delay)) {}

  Checked<BuiltScene> run() {
    built_.delay_frames = static_cast<int>(std::lround(frames_in(delay_, rate_)));
    route_set();
    make_world();
    wire_instrument();
    compile_world();
    compile_instrument();
    if (!mistakes_.empty()) {
      sort_by_place(mistakes_);
      return tl::unexpected(std::move(mistakes_));
    }
    return std::move(built_);
  }

 private:
  void complain(Errc code, const Source& at, std::string what, std::string remedy) {
    mistakes_.push_back({code, at.text(), std::move(what), std::move(remedy)});
  }
  void keep(std::vector<Error> more) {
    for (auto& error : more) mistakes_.push_back(std::move(error));
  }

  /// "strength" is the instrument's; "plant.gain" overwrites a wire of a part.
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
  // --------------------------------------------------

  void make_world() {
    world_.file = scene_.file;
    world_.name = scene_.name;
    for (const auto& output : instrument_.graph->outputs)
      world_.inputs.push_back({"instrument." + output.name, output.at, {}});
    for (const auto& gesture : scene_.gestures) world_.nodes.push_back(gesture_node(gesture));
    for (const auto& part : scene_.parts) {
      if (part.name == "instrument") continue;
      NodeSpec node;
      node.name = part.name;
      node.at = part.at;
      node.use = part.name;
      node.fields = part.wires;
      for (const auto& [port, value] : overwritten_[part.name]) overwrite(node.fields, port, value, part.at);
      world_.parts[part.name] = part.graph;
      world_.nodes.push_back(std::move(node));
      for (const auto& output : part.graph->outputs) taps_.push_back(part.name + "." + output.name);
    }
    for (const auto& [name, fields] : overwritten_)
      if (!fields.empty() && scene_.part(name) == nullptr)
        complain(Errc::UnknownName, scene_.file,
                 "there is no part '" + name + "' to set '" + fields.begin()->first + "' of",
                 "see [parts] of the scene");
  }

  static void overwrite(Value::Table& fields, const std::string& port, double value, const Source& at) {
    for (auto& field : fields)
      if (field.key == port) {
        field.value.data = value;
        return;
      }
    fields.push_back({port, at, {value, at}});
  }

  void wire_instrument() {
    const auto& graph = *instrument_.graph;
    for (const auto& input : graph.inputs) {
      const auto* wire = find(instrument_.wires, input.name);
      if (wire == nullptr) {
        complain(Errc::Missing, instrument_.at, "input '" + input.name + "' of the instrument is not wired",
                 "say where it comes from, as in " + input.name + " = \"plant." + input.name + "\"");
        continue;
      }
      EntrySpec output{"instrument." + input.name, wire->at, {{"from", wire->at, *wire}}};
      if (const auto* unit = find(input.fields, "unit")) output.fields.push_back({"unit", unit->at, *unit});
      world_.outputs.push_back(std::move(output));
    }
    for (const auto& field : instrument_.wires) {
      if (find_entry(graph.inputs, field.key) != nullptr) continue;
      if (const auto* control = find_entry(graph.controls, field.key))
        wire_control(*control, field);
      else
        complain_unknown(field);
    }
  }

  void complain_unknown(const Field& field) {
    std::vector<std::string> names;
    for (const auto& entry : instrument_.graph->inputs) names.push_back(entry.name);
    for (const auto& entry : instrument_.graph->controls) names.push_back(entry.name);
    const auto near = nearest_name(field.key, names);
    complain(Errc::UnknownName, field.at, "the instrument has no input or control '" + field.key + "'",
             near.empty() ? "see its [inputs] and [controls]" : "did you mean '" + near + "'?");
  }

  /// A number sets where the control starts; a gesture moves it, by way of the journal.
  void wire_control(const EntrySpec& control, const Field& field) {
    const auto* text = field.value.text();
    if (const auto* gesture = text != nullptr ? scene_.gesture(*text) : nullptr) {
      moved_.push_back({control.name, gesture});
      if (!controls_.contains(control.name)) controls_[control.name] = gesture->points.front().value;
      return;
    }
    const auto value = read_quantity(field.value);
    if (!value) return mistakes_.push_back(value.error());
    controls_.try_emplace(control.name, value->si);
  }

  // ---- compiling
  // ---------------------------------------------------------------------------------------------

  void compile_world() {
    CompileOptions options;
    options.sample_rate = rate_;
    options.system_delay = delay_;
    options.taps = taps_;
    options.closed_outside = built_.delay_frames == 0;
    auto compiled = compile(world_, table_, options);
    if (!compiled) return keep(std::move(compiled.error()));
    for (const auto& channel : (*compiled)->channels)
      if (channel.use == OutputUse::Tap) built_.plant_taps.push_back({channel.name, channel.dimension});
    built_.plant = std::make_unique<Engine>(std::move(*compiled));
  }

  void compile_instrument() {
    CompileOptions options;
    options.sample_rate = rate_;
    options.system_delay = delay_;
    options.controls = controls_;
    options.taps = event_taps(*instrument_.graph, table_);
    auto compiled = compile(*instrument_.graph, table_, options);
    if (!compiled) return keep(std::move(compiled.error()));
    for (const auto& channel : (*compiled)->channels)
      if (channel.use == OutputUse::Tap)
        built_.instrument_taps.push_back({"instrument." + channel.name, channel.dimension});
    built_.instrument = std::make_unique<Engine>(std::move(*compiled));
    built_.instrument->set_journal(journal());
  }

  /// A step becomes an entry at its frame; a slope becomes one a millisecond, which the control's own
  /// smoothing joins.
  std::vector<JournalEntry> journal() const {
    std::vector<JournalEntry> entries;
    for (const auto& [control, gesture] : moved_) {
      const int index = built_.instrument->schedule().control_index(control);
      const auto add = [&](double time_s, double value) {
        entries.push_back(
            {std::lround(time_s * rate_.value), JournalEntry::Kind::ControlChange, index, value});
      };
      const auto& points = gesture->points;
      for (std::size_t i = 0; i < points.size(); ++i) {
        add(points[i].time_s, points[i].value);
        if (gesture->curve == Gesture::Curve::Step || i + 1 == points.size()) continue;
        const auto& next = points[i + 1];
        for (double t = points[i].time_s + 1e-3; t < next.time_s; t += 1e-3) {
          double u = (t - points[i].time_s) / (next.time_s - points[i].time_s);
          if (gesture->curve == Gesture::Curve::Smooth) u = u * u * (3 - 2 * u);
          add(t, points[i].value + (next.value - points[i].value) * u);
        }
      }
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& a, const auto& b) { return a.frame < b.frame; });
    return entries;
  }

  struct Moved {
    std::string control;
    const Gesture* gesture;
  };

  const SceneSpec& scene_;
  const NodeTable& table_;
  const SceneOptions& options_;
  const ScenePart& instrument_;
  Hertz rate_;
  Seconds delay_;
  GraphSpec world_;
  std::vector<std::string> taps_;
  std::map<std::string, double> controls_;
  std::map<std::string, std::map<std::string, double>> overwritten_;
  std::vector<Moved> moved_;
  std::vector<Error> mistakes_;
  BuiltScene built_;
};

}  // namespace

Checked<BuiltScene> build_scene(const SceneSpec& scene, const NodeTable& table, const SceneOptions& options) {
  return SceneBuilder{scene, table, options}.run();
}

std::vector<std::string> event_taps(const GraphSpec& graph, const NodeTable& table) {
  std::vector<std::string> taps;
  for (const auto& node : graph.nodes) {
    const auto* type = table.find(node.type);
    if (type == nullptr) continue;
    for (const auto& output : type->outputs)
      if (output.kind == OutputKind::Trigger) taps.push_back(node.name + "." + output.name);
    if (!taps.empty() && taps.back().starts_with(node.name + ".") && type->output_index("level") >= 0)
      taps.push_back(node.name + ".level");
  }
  return taps;
}

}  // namespace tactus
