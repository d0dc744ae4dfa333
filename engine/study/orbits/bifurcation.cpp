#include "engine/study/orbits/bifurcation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/index.h"
#include "engine/core/median.h"
#include "engine/core/named.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"
#include "engine/study/orbits/bouncing_ball.h"
#include "engine/study/sweep/sweep.h"

namespace tactus {
namespace {

constexpr double kGravity = 9.81;   // [m/s^2]
constexpr int kColumnsOfARun = 12;  // of the simulation; fixed, so that cores change nothing
constexpr int kColumnsBefore = 3;   // are played first and not read: a doubled orbit takes time to come apart
constexpr int kFittedColumns = 4;
constexpr int kFinerExactly = 4;      // the map costs next to nothing
constexpr int kExactSettling = 1500;  // bounces
constexpr int kExactRead = 64;

constexpr const char* kGesture = "swept_by_the_study";
constexpr double kGlide_s = 3.0, kBifurcationSweepStep_s = 0.1;

/// The value of a control in the scene, or else in its graph file; none if it is not a number.
std::optional<double> set_value(const ScenePart& part, const ControlSpec& control) {
  const auto* value = find(part.wires, control.name);
  if (value == nullptr) return control.control.value;
  const auto quantity = read_quantity(*value);
  return quantity ? std::optional{quantity->si} : std::nullopt;
}

tl::unexpected<Error> no_control(const std::string& name, const std::string& what) {
  return fail(Errc::UnknownName, name, what,
              "give --control gamma, or --control plant.gamma for a control of the plant");
}

double value_at(const BifurcationPlan& plan, int i, int values) {
  return plan.from + (plan.to - plan.from) * i / (values - 1);
}

/// A column without its period.
void add(BifurcationColumn& column, double speed, double turns) {
  column.speeds.push_back(speed);
  column.phases.push_back(turns - std::floor(turns));
}

/// The ideal ball, from the orbit of one bounce a period on; nothing where that is not there to begin with.
std::vector<BifurcationColumn> sweep_exactly(const BifurcationPlan& plan, double e, double frequency) {
  constexpr double kTurn = 2 * std::numbers::pi;
  std::vector<BifurcationColumn> columns;
  if (plan.from <= BouncingBall::orbit_begins(1, e)) return columns;
  auto bounce = BouncingBall{plan.from, e}.orbit(1);
  const int values = kFinerExactly * (plan.values - 1) + 1;
  const double metre_per_s = kGravity / (kTurn * frequency);
  for (int i = 0; i < values; ++i) {
    auto& column = columns.emplace_back();
    column.value = value_at(plan, i, values);
    const BouncingBall ball{column.value, e};
    for (int n = 0; n < kExactSettling + kExactRead; ++n) {
      bounce.phase = std::fmod(bounce.phase, kTurn);
      bounce = ball.next(bounce);
      // It leaves as fast as it came, times e.
      const double came = (bounce.speed - column.value * std::cos(bounce.phase)) / e;
      if (n >= kExactSettling) add(column, came * metre_per_s, bounce.phase / kTurn);
    }
    column.period = period_of(column.speeds);
  }
  return columns;
}

std::vector<Doubling> doublings_of(const Bifurcation& found) {
  std::vector<Doubling> doublings;
  constexpr int kSought = 3;
  int bounces = 1;
  for (const double exact : period_doublings(1, found.restitution, kSought)) {
    doublings.push_back(
        {bounces, doubling_in(found.simulated, bounces), doubling_in(found.exact, bounces), exact});
    bounces *= 2;
  }
  return doublings;
}

/// Finds the control and the frequency; a gesture, the last one, moves the control from then on.
Status find_control(SceneSweep& sweep, const std::string& control) {
  auto& scene = sweep.scene;
  const auto dot = control.find('.');
  const auto part_name = dot == std::string::npos ? std::string{"instrument"} : control.substr(0, dot);
  const auto name = dot == std::string::npos ? control : control.substr(dot + 1);
  const auto part = std::ranges::find(scene.parts, part_name, &ScenePart::name);
  if (part == scene.parts.end() || part->graph == nullptr)
    return no_control(control, "the scene has no part '" + part_name + "'");
  if (find_named(part->graph->controls, name) == nullptr)
    return no_control(control, "there is no control '" + name + "' in the part '" + part_name + "'");
  const auto* frequency = find_named(part->graph->controls, "frequency");
  const auto hertz = frequency != nullptr ? set_value(*part, *frequency) : std::nullopt;
  if (!hertz || !(*hertz > 0))
    return fail(Errc::Missing, part->at.text(), "the frequency of the table is not known",
                "give the part a control 'frequency' with a constant value");
  sweep.frequency_hz = *hertz;
  sweep.of_the_table = name == "gamma";
  std::erase_if(part->wires, [&](const Field& field) { return field.key == name; });
  part->wires.push_back({name, part->at, Value{std::string{kGesture}, part->at}});
  scene.gestures.push_back({.name = kGesture, .at = part->at, .bare = true});
  scene.expect.clear();
  scene.ports.clear();
  scene.compare.reset();
  return {};
}

}  // namespace

Checked<SceneSweep> make_sweep(const SceneSpec& scene, const NodeTable& table, const BifurcationPlan& plan) {
  SceneSweep sweep{scene};
  if (auto status = find_control(sweep, plan.control); !status)
    return tl::unexpected(std::vector{status.error()});
  sweep.scene.gestures.back().points = {{0, plan.from}};
  if (const auto compiled = compile_scene(sweep.scene, table); !compiled)
    return tl::unexpected(compiled.error());
  return sweep;
}

Checked<std::vector<std::vector<Landing>>> play_sweep(const SceneSweep& sweep, const NodeTable& table,
                                                      const BifurcationPlan& plan,
                                                      const std::vector<double>& values) {
  auto scene = sweep.scene;
  auto& points = scene.gestures.back().points;
  std::vector<double> starts;
  double time = kGlide_s;
  for (const double value : values) {
    starts.push_back(time);
    points.push_back({time, value});
    points.push_back({time += plan.settling_s + plan.reading_s, value});
    time += kBifurcationSweepStep_s;
  }
  scene.duration = Seconds{time};
  const auto recording = play_run({{}, scene}, table);
  if (!recording) return tl::unexpected(recording.error());
  const auto *ball = recording->find(signal_of(scene.roles, "ball")),
             *floor = recording->find(signal_of(scene.roles, "table"));
  if (ball == nullptr || floor == nullptr)
    return tl::unexpected(std::vector{Error{Errc::Missing, scene.file.text(),
                                            "the scene has no signals with the roles 'ball' and 'table'",
                                            "give two positions under [roles]"}});
  const auto landings = landings_of(ball->samples, floor->samples, recording->sample_rate);
  std::vector<std::vector<Landing>> held;
  for (const double start : starts) {
    const double from = start + plan.settling_s;
    std::ranges::copy_if(landings, std::back_inserter(held.emplace_back()), [&](const Landing& l) {
      return l.time_s >= from && l.time_s < from + plan.reading_s;
    });
  }
  return held;
}

std::optional<double> doubling_in(const std::vector<BifurcationColumn>& columns, int bounces) {
  const auto behind = std::ranges::find(columns, 2 * bounces, &BifurcationColumn::period);
  if (behind == columns.begin() || behind == columns.end() || behind[-1].period != bounces)
    return std::nullopt;
  // The straight line nearest to the first columns behind it.
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (auto c = behind; c != columns.end() && c->period == 2 * bounces && n < kFittedColumns; ++c, ++n) {
    const double value = c->value - behind->value, squared = std::pow(split_of(c->speeds, bounces), 2);
    x += value;
    y += squared;
    xx += value * value;
    xy += value * squared;
  }
  const double slope = (n * xy - x * y) / (n * xx - x * x);
  if (!(n > 1 && slope > 0)) return 0.5 * (behind[-1].value + behind->value);
  return behind->value + (x - y / slope) / n;
}

Checked<Bifurcation> study_bifurcation(const SceneSpec& scene, const NodeTable& table,
                                       const BifurcationPlan& plan,
                                       const std::function<void(double)>& progress) {
  const auto sweep = make_sweep(scene, table, plan);
  if (!sweep) return tl::unexpected(sweep.error());
  Bifurcation found{scene.name, plan.control, sweep->frequency_hz, 0, 0, {}, {}, {}};
  const int runs = (plan.values + kColumnsOfARun - 1) / kColumnsOfARun;
  std::vector<Checked<std::vector<std::vector<Landing>>>> results(index(runs));
  const auto run = [&](int r) {
    const int first = r * kColumnsOfARun, before = std::min(first, kColumnsBefore);
    std::vector<double> values;
    for (int i = first - before; i < std::min(plan.values, first + kColumnsOfARun); ++i)
      values.push_back(value_at(plan, i, plan.values));
    auto& result = results[index(r)] = play_sweep(*sweep, table, plan, values);
    if (result) result->erase(result->begin(), result->begin() + before);
  };
  parallel_for(
      runs, run, progress ? progress : [](double) {});
  std::vector<double> rebounds;
  for (const auto& result : results) {
    if (!result) return tl::unexpected(result.error());
    for (const auto& landings : *result) {
      auto& column = found.simulated.emplace_back();
      column.value = value_at(plan, static_cast<int>(found.simulated.size()) - 1, plan.values);
      for (const auto& landing : landings) add(column, landing.speed, landing.time_s * found.frequency_hz);
      column.period = period_of(column.speeds);
      if (column.period == 1)
        for (const auto& landing : landings) rebounds.push_back(landing.rebound / landing.speed);
    }
  }
  found.measured_restitution = median(std::move(rebounds));
  found.restitution = plan.restitution.value_or(found.measured_restitution);
  if (!(found.restitution > 0 && found.restitution < 1) || !sweep->of_the_table) return found;
  found.exact = sweep_exactly(plan, found.restitution, found.frequency_hz);
  found.doublings = doublings_of(found);
  return found;
}

}  // namespace tactus
