#include "engine/study/orbits/bifurcation_sweep.h"

#include <algorithm>
#include <cmath>

#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/play_scene.h"

namespace tactus {
namespace {

constexpr const char* kGesture = "swept_by_the_study";
constexpr double kGlide_s = 3.0, kBifurcationSweepStep_s = 0.1;

/// The control of a part, as its file has it; nullptr if there is none.
const EntrySpec* control_of(const ScenePart& part, std::string_view name) {
  const auto& controls = part.graph->controls;
  const auto found =
      std::find_if(controls.begin(), controls.end(), [&](const auto& c) { return c.name == name; });
  return found == controls.end() ? nullptr : &*found;
}

/// What the scene sets a control to, or else its file; nothing if that is no number.
std::optional<double> set_value(const ScenePart& part, const EntrySpec& control) {
  const auto* value = find(part.wires, control.name);
  if (value == nullptr) value = find(control.fields, "value");
  const auto quantity = value != nullptr ? read_quantity(*value) : Result<QuantityValue>{};
  return value != nullptr && quantity ? std::optional{quantity->si} : std::nullopt;
}

tl::unexpected<Error> no_control(const std::string& name, const std::string& what) {
  return fail(Errc::UnknownName, name, what,
              "name one as in --control gamma, or plant.gamma of another part");
}

/// Of the landings between two times.
std::vector<Landing> between(const std::vector<Landing>& all, double from_s, double to_s) {
  std::vector<Landing> found;
  std::copy_if(all.begin(), all.end(), std::back_inserter(found),
               [&](const Landing& l) { return l.time_s >= from_s && l.time_s < to_s; });
  return found;
}

}  // namespace

Checked<SceneSweep> SceneSweep::make(const SceneSpec& scene, const NodeTable& table,
                                     const BifurcationPlan& plan) {
  SceneSweep sweep{scene, table, plan};
  if (auto status = sweep.find_control(); !status) return tl::unexpected(std::vector{status.error()});
  auto tried = sweep.scene_;
  tried.gestures.back().points = {{0, plan.from}};
  if (const auto compiled = compile_scene(tried, table); !compiled) return tl::unexpected(compiled.error());
  return sweep;
}

Status SceneSweep::find_control() {
  const auto dot = plan_.control.find('.');
  const auto part_name = dot == std::string::npos ? std::string{"instrument"} : plan_.control.substr(0, dot);
  const auto name = dot == std::string::npos ? plan_.control : plan_.control.substr(dot + 1);
  const auto part = std::find_if(scene_.parts.begin(), scene_.parts.end(),
                                 [&](const auto& p) { return p.name == part_name; });
  if (part == scene_.parts.end() || part->graph == nullptr)
    return no_control(plan_.control, "the scene has no part '" + part_name + "'");
  if (control_of(*part, name) == nullptr)
    return no_control(plan_.control, "there is no control '" + name + "' in the part '" + part_name + "'");
  const auto* frequency = control_of(*part, "frequency");
  const auto hertz = frequency != nullptr ? set_value(*part, *frequency) : std::nullopt;
  if (!hertz || !(*hertz > 0))
    return fail(Errc::Missing, part->at.text(), "nothing says how often the table goes up and down",
                "give the part a control 'frequency', at a number");
  frequency_ = *hertz;
  of_the_table_ = name == "gamma";
  std::erase_if(part->wires, [&](const Field& field) { return field.key == name; });
  part->wires.push_back({name, part->at, Value{std::string{kGesture}, part->at}});
  Gesture gesture;
  gesture.name = kGesture;
  gesture.at = part->at;
  gesture.bare = true;
  scene_.gestures.push_back(std::move(gesture));
  scene_.expect.clear();
  scene_.ports.clear();
  scene_.compare.reset();
  return {};
}

SweepResult SceneSweep::run(const std::vector<double>& values) const {
  auto scene = scene_;
  auto& points = scene.gestures.back().points;
  points = {{0, plan_.from}};
  std::vector<double> starts;
  double time = kGlide_s;
  for (const double value : values) {
    starts.push_back(time);
    points.push_back({time, value});
    points.push_back({time += plan_.settling_s + plan_.reading_s, value});
    time += kBifurcationSweepStep_s;
  }
  scene.duration = Seconds{time};
  auto built = build_scene(scene, *table_);
  if (!built) return tl::unexpected(built.error().front());
  const auto recording = play_scene(scene, *built, 256);
  if (!recording) return tl::unexpected(recording.error());
  const auto *ball = recording->find(signal_of(scene.roles, "ball")),
             *floor = recording->find(signal_of(scene.roles, "table"));
  if (ball == nullptr || floor == nullptr)
    return fail(Errc::Missing, scene.file.text(),
                "the scene has no signals with the roles 'ball' and 'table'",
                "name two positions under [roles]");
  const auto landings = landings_of(ball->samples, floor->samples, recording->sample_rate);
  std::vector<HeldValue> held;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double from = starts[i] + plan_.settling_s;
    held.push_back({values[i], between(landings, from, from + plan_.reading_s)});
  }
  return held;
}

}  // namespace tactus
