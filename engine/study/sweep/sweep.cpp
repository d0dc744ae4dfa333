#include "engine/study/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/core/index.h"
#include "engine/core/named.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"
#include "engine/scene/measures/measure.h"
#include "engine/study/sweep/scene_variants.h"

namespace tactus {
namespace {

using What = SweptValue::What;

constexpr int kSweepBlock = 256;

std::string did_you_mean(const std::string& name, const std::vector<std::string>& names,
                         const std::string& otherwise) {
  const auto near = nearest_name(name, names);
  return (near.empty() ? "" : "did you mean '" + near + "'? ") + otherwise;
}

Error unknown_name(const SceneSpec& scene, const std::string& name) {
  std::vector<std::string> all{"delay", "rate", "solver", "oversample"};
  std::string known = "parameters of the scene: delay, rate, solver, oversample";
  for (const auto& [kind, names] : {std::pair{"controls", control_names(scene)},
                                    {"gestures", names_of(scene.gestures)},
                                    {"constants", constant_names(scene)}}) {
    all.insert(all.end(), names.begin(), names.end());
    if (!names.empty()) known += fmt::format("; {}: {}", kind, listed(names));
  }
  return {Errc::UnknownName, "--over", "the scene has no parameter '" + name + "'",
          did_you_mean(name, all, known)};
}

/// Quantities that every scene has, with their limits.
struct SceneQuantity {
  const char* name;
  What what;
  Dimension dimension;
  double low, high;
  const char* range;
};
const SceneQuantity kSceneQuantities[] = {
    {"delay", What::Delay, {.second = 1}, 0, 1, "choose 0 s to 1 s"},
    {"rate", What::Rate, {.second = -1}, 1e3, 768e3, "choose 1 kHz to 768 kHz"},
    {"oversample", What::Oversample, {}, 1, 64, "choose 1 to 64"}};

Status check_range(const SweptValue& swept, const SceneQuantity& quantity) {
  for (const auto& value : swept.values) {
    if (value.dimension && !(*value.dimension == quantity.dimension))
      return fail(Errc::UnitMismatch, "--over", "'" + swept.name + "' has another unit", quantity.range);
    if (!(value.si >= quantity.low && value.si <= quantity.high))
      return fail(Errc::OutOfRange, "--over",
                  fmt::format("'{}' = {:g} is out of range", swept.name, value.si), quantity.range);
  }
  return {};
}

void apply(Sweep::Run& run, const SweptValue& swept, double si) {
  auto& scene = run.scene;
  auto value = swept.values.front();
  value.si = si;
  switch (swept.what) {
    case What::Control:
      run.options.set[swept.name] = value;
      break;
    case What::Scaled:
      scene = with_gesture_scaled(std::move(scene), swept.name, si);
      break;
    case What::Held:
      scene = with_gesture_held(std::move(scene), swept.name, si);
      break;
    case What::Constant:
      scene = with_constant(std::move(scene), swept.name, value);
      break;
    case What::Delay:
      scene.delay = Seconds{si};
      break;
    case What::Rate:
      scene.rate = Hertz{si};
      break;
    case What::Solver:
      scene = with_network_option(std::move(scene), "solver", swept.names[static_cast<std::size_t>(si)]);
      break;
    case What::Oversample:
      scene = with_network_option(std::move(scene), "oversample", si);
      break;
  }
}

/// Errors: BadArgument of a control that a gesture moves; UnitMismatch of a held gesture.
Status check_swept(const SceneSpec& scene, const SweptValue& swept) {
  const auto* gesture = scene.gesture(swept.name);
  const auto& value = swept.values.front();
  if (swept.what == What::Held && gesture != nullptr && !gesture->bare &&
      !(value.dimension == gesture->unit.dimension))
    return fail(Errc::UnitMismatch, "--over",
                fmt::format("gesture '{}' is in {}, not in {}", swept.name,
                            to_string(gesture->unit.dimension), to_string(*value.dimension)),
                "use the unit of the gesture, or none to scale the gesture");
  const auto* instrument = scene.part("instrument");
  const auto* wire = instrument != nullptr ? find(instrument->wires, swept.name) : nullptr;
  const auto* text = wire != nullptr ? wire->text() : nullptr;
  if (gesture == nullptr && text != nullptr && scene.gesture(*text) != nullptr)
    return fail(Errc::BadArgument, "--over", "control '" + swept.name + "' is set by gesture '" + *text + "'",
                "sweep the gesture: --over " + *text +
                    "=0.5:2:4 scales it; values with a unit replace it by a constant");
  return {};
}

}  // namespace

Result<SweptValue> find_swept(const SceneSpec& scene, const std::string& name,
                              std::vector<ControlValue> values) {
  SweptValue swept{name, std::move(values)};
  const auto controls = control_names(scene), constants = constant_names(scene);
  const auto is_in = [&](const std::vector<std::string>& names) {
    return std::ranges::find(names, name) != names.end();
  };
  const auto* quantity = std::find_if(std::begin(kSceneQuantities), std::end(kSceneQuantities),
                                      [&](const SceneQuantity& known) { return name == known.name; });
  Status status;
  if (scene.gesture(name) != nullptr) {
    swept.what = swept.values.front().dimension ? What::Held : What::Scaled;
  } else if (is_in(controls)) {
    swept.what = What::Control;
  } else if (quantity != std::end(kSceneQuantities)) {
    swept.what = quantity->what;
    status = check_range(swept, *quantity);
  } else if (is_in(constants)) {
    swept.what = What::Constant;
  } else {
    return tl::unexpected(unknown_name(scene, name));
  }
  if (!status) return tl::unexpected(status.error());
  return swept;
}

Result<SweptValue> swept_solvers(const std::vector<std::string>& names, const char* option) {
  const auto known = stepping_solvers();
  SweptValue swept{"solver", {}, What::Solver, names};
  for (std::size_t i = 0; i < names.size(); ++i) {
    swept.values.emplace_back(static_cast<double>(i));
    if (std::ranges::find(known, names[i]) == known.end())
      return fail(Errc::UnknownName, option, "there is no solver '" + names[i] + "'",
                  "the solvers are " + listed(known));
  }
  return swept;
}

std::uint64_t run_key(const std::string& what, const Sweep::Run& run) {
  // Increased when the meaning of cached numbers changes.
  constexpr std::uint64_t kEdition = 4;
  Fingerprint print;
  add(print.add(kEdition).add(what), run.scene);
  for (const auto& [name, value] : run.options.set) print.add(name).add(value.si);
  return print.value();
}

std::string measure_key(const MeasureEntry& measure) {
  return fmt::format("|{} {} {} {}", measure.measure, measure.of, measure.from_s.value_or(-1),
                     measure.to_s.value_or(-1));
}

Sweep::Sweep(const SceneSpec& scene, const NodeTable& table, const SweepPlan& plan)
    : scene_(scene), table_(table), plan_(plan), variants_{{kAsWritten}} {
  for (const double gain : plan.gains) variants_.push_back({fmt::format("actuator x {:.3g}", gain), gain});
  for (int draw = 1; draw <= plan.draws; ++draw) variants_.push_back({fmt::format("draw {}", draw), 1, draw});
  std::size_t settings = 1;
  for (const auto& swept : plan.over) settings *= swept.values.size();
  for (std::size_t i = 0; i < settings; ++i) {
    std::vector<double> at(plan.over.size());
    for (auto rest = i, a = at.size(); a-- > 0; rest /= plan.over[a].values.size())
      at[a] = plan.over[a].values[rest % plan.over[a].values.size()].si;
    for (const auto& variant : variants_) points_.push_back({at, variant.name, std::nullopt});
  }
}

Sweep::Run Sweep::run_of(std::size_t number) const {
  const auto& variant = variants_[number % variants_.size()];
  Run run{points_[number].at, scene_, {}, number};
  run.options.set = plan_.set;
  for (std::size_t i = 0; i < plan_.over.size(); ++i) apply(run, plan_.over[i], run.at[i]);
  if (variant.gain != 1) run.scene = with_actuator_gain(std::move(run.scene), variant.gain);
  if (variant.draw > 0)
    run.scene = with_plant_drawn(std::move(run.scene), plan_.within,
                                 plan_.seed * 0x9e3779b97f4a7c15u + std::uint64_t(variant.draw));
  return run;
}

Checked<void> Sweep::check() const {
  for (const auto& swept : plan_.over)
    if (auto status = check_swept(scene_, swept); !status) return tl::unexpected(std::vector{status.error()});
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto variant = i % variants_.size();
    std::size_t moved = variant == 0 ? 0 : 1;
    for (std::size_t a = 0; a < plan_.over.size(); ++a)
      moved += points_[i].at[a] == plan_.over[a].values.front().si ? 0 : 1;
    if (moved > 1 && i + 1 < points_.size()) continue;
    const auto run = run_of(i);
    if (auto made = compile_scene(run.scene, table_, run.options); !made)
      return tl::unexpected(std::move(made.error()));
  }
  return {};
}

Checked<std::vector<SweepPoint>> Sweep::evaluate(const Evaluate& evaluate, const std::string& key) {
  auto results = evaluate_runs(
      plan_, static_cast<int>(points_.size()), [&](int i) { return run_key(key, run_of(index(i))); },
      [&](int i) { return evaluate(run_of(index(i))); });
  if (!results) return tl::unexpected(results.error());
  auto points = points_;
  for (std::size_t i = 0; i < points.size(); ++i) points[i].result = std::move((*results)[i]);
  return points;
}

Checked<SceneRecording> play_run(const Sweep::Run& run, const NodeTable& table) {
  auto built = build_scene(run.scene, table, run.options);
  if (!built) return tl::unexpected(built.error());
  return play_scene(run.scene, *built, kSweepBlock).map_error([](Error error) { return std::vector{error}; });
}

Result<Expectation> find_swept_measure(const SceneSpec& scene, const std::string& text) {
  if (const auto* line = find_named(scene.expect, text)) return *line;
  const auto colon = text.find(':');
  Expectation what;
  what.name = text;
  what.measure = text.substr(0, colon);
  if (colon != std::string::npos) what.of = text.substr(colon + 1);
  if (const auto* found = find_measure(what.measure); found != nullptr && found->value != nullptr)
    return what;
  auto names = names_of(scene.expect);
  for (const auto& known : value_names())
    if (std::ranges::find(names, known) == names.end()) names.push_back(known);
  return fail(Errc::UnknownName, "--measure", "there is no measure '" + what.measure + "'",
              did_you_mean(what.measure, names, "the measures are " + listed(names)));
}

Checked<SweepTable> sweep_measures(const SceneSpec& scene, const NodeTable& table, const SweepPlan& plan,
                                   const std::vector<Expectation>& measures) {
  Sweep sweep{scene, table, plan};
  if (auto status = sweep.check(); !status) return tl::unexpected(status.error());
  std::string key = "measures";
  for (const auto& measure : measures) key += measure_key(measure);
  const auto measure_run = [&](const Sweep::Run& run) -> Checked<RunResult> {
    const auto recording = play_run(run, table);
    if (!recording) return tl::unexpected(recording.error());
    RunResult values;
    for (const auto& swept : measures) {
      const auto value = measure(*recording, swept);
      if (!value) return tl::unexpected(std::vector{value.error()});
      values.push_back(*value);
    }
    return values;
  };
  auto points = sweep.evaluate(measure_run, key);
  if (!points) return tl::unexpected(points.error());
  return SweepTable{scene.name, plan.over, measures, names_of(sweep.variants()), std::move(*points)};
}

std::string unit_of(const Expectation& measure) {
  const auto* type = find_measure(measure.measure);
  return type == nullptr || type->unit == Measure::kUnitOfSubject ? std::string{} : type->unit;
}

std::string value_text(const SweptValue& swept, double si) {
  if (!swept.names.empty()) return swept.names[static_cast<std::size_t>(si)];
  const auto digits = fmt::format("{:.3g}", si);
  if (swept.what == What::Scaled) return "x " + digits;
  const auto& dimension = swept.values.front().dimension;
  return dimension ? short_quantity(std::stod(digits), *dimension) : digits;
}

std::vector<std::string> value_texts(const SweptValue& swept) {
  std::vector<std::string> texts;
  for (const auto& value : swept.values) texts.push_back(value_text(swept, value.si));
  return texts;
}

std::string setting_text(const std::vector<SweptValue>& over, const std::vector<double>& at) {
  std::string text;
  for (std::size_t i = 0; i < over.size(); ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", over[i].name, value_text(over[i], at[i]));
  return text;
}

}  // namespace tactus
