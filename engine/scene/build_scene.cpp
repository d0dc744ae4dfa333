#include "engine/scene/build_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/named.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/plan/compile.h"
#include "engine/scene/guard_report.h"
#include "engine/scene/scene_wiring.h"

namespace tactus {
namespace {

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
    compile_world();
    if (instrument_known())
      compile_instrument();
    else if (has_no_instrument())
      compile_silence();
    if (built_.plant != nullptr && built_.instrument != nullptr) check_channels();
    if (errors_.any()) return tl::unexpected(errors_.take());
    check_size();
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
    declare_drives();
    for (const auto& gesture : scene_.gestures) world_.nodes.push_back(gesture_node(gesture));
    for (const auto& part : scene_.parts) {
      if (part.name == "instrument") continue;
      NodeSpec node;
      node.name = part.name;
      node.at = part.at;
      node.use = part.name;
      node.fields = part.wires;
      for (const auto& [port, value] : overwritten_[part.name]) overwrite(node.fields, port, value, part.at);
      if (options_.by_hand && part.graph != nullptr) strike_by_hand(*part.graph, node, world_);
      node.broken = part.graph == nullptr;
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

  /// The instrument's outputs are inputs of the plant.
  void declare_drives() {
    if (has_no_instrument()) return;
    NodeSpec unknown;
    unknown.name = "instrument";
    unknown.broken = true;
    if (!instrument_known() || instrument_->graph->incomplete) return world_.nodes.push_back(unknown);
    for (const auto& output : instrument_->graph->outputs)
      world_.inputs.push_back({{"instrument." + output.name, output.at, {}}});
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
    for (const auto& field : instrument_->wires) {
      if (find_named(graph.inputs, field.key) != nullptr) continue;
      if (const auto* control = find_named(graph.controls, field.key))
        wire_control(*control, field);
      else if (!graph.incomplete)
        report_unknown(field);
    }
  }

  void report_unknown(const Field& field) {
    auto names = names_of(instrument_->graph->inputs);
    for (const auto& control : instrument_->graph->controls) names.push_back(control.name);
    errors_.add(Errc::UnknownName, field.at, "the instrument has no input or control '" + field.key + "'",
                suggest(field.key, names, "see its [inputs] and [controls]"));
  }

  void wire_control(const ControlSpec& control, const Field& field) {
    const auto wired = tactus::wire_control(scene_, control, field, errors_);
    if (!wired) return;
    const bool asked = !controls_.try_emplace(control.name, wired->start).second;
    if (wired->gesture != nullptr && !asked) moved_.push_back({control.name, wired->gesture});
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
    CompileOptions options;
    options.sample_rate = rate_;
    options.system_delay = delay_;
    options.vectorise = options_.vectorise;
    options.taps = std::move(taps);
    return options;
  }

  static std::vector<SceneTap> taps_of(const Plan& plan, const std::string& prefix) {
    std::vector<SceneTap> taps;
    for (const auto& channel : plan.channels)
      if (channel.use == OutputUse::Tap) taps.push_back({prefix + channel.name, channel.dimension});
    return taps;
  }

  void compile_world() {
    auto options = compile_options(taps_);
    options.closed_outside = built_.delay_frames == 0;
    auto compiled = compile_or_check(world_, options);
    if (compiled == nullptr) return;
    built_.plant_taps = taps_of(*compiled, "");
    check_expected_pitch(scene_, built_.plant_taps, errors_);
    built_.plant = std::move(compiled);
  }

  /// All that is recorded must fit into memory.
  void check_size() {
    constexpr double kMaxSamples = 1u << 29;
    const auto signals =
        static_cast<double>(built_.plant->channels.size() + built_.instrument->channels.size());
    const double samples = signals * frames_in(scene_.duration, rate_);
    if (samples > kMaxSamples)
      errors_.add(Errc::OutOfRange, scene_.file,
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

  void compile_silence() {
    GraphSpec nothing;
    nothing.file = scene_.file;
    CompileOptions options;
    options.sample_rate = rate_;
    built_.instrument = compile_or_check(nothing, options);
  }

  void compile_instrument() {
    auto options = compile_options(event_taps(*instrument_->graph, table_));
    options.controls = controls_;
    auto compiled = compile_or_check(*instrument_->graph, options);
    if (compiled == nullptr) return;
    built_.instrument_taps = taps_of(*compiled, "instrument.");
    built_.journal = gesture_journal(moved_, *compiled);
    built_.instrument = std::move(compiled);
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
    : instrument(std::make_unique<Player>(std::move(compiled.instrument))),
      plant(std::make_unique<Player>(std::move(compiled.plant))),
      delay_frames(compiled.delay_frames),
      plant_taps(std::move(compiled.plant_taps)),
      instrument_taps(std::move(compiled.instrument_taps)) {
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
  return taps;
}

}  // namespace tactus
