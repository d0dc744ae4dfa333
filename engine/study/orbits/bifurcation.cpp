#include "engine/study/orbits/bifurcation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/median.h"
#include "engine/core/named.h"
#include "engine/graph/file/error_list.h"
#include "engine/scene/measures/motion.h"
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

/// A scene whose control is moved by a gesture of its own, the last one.
struct GlidingScene {
  SceneSpec scene;
  std::string control;
  double frequency_hz = 0;
  bool of_the_table = false;  ///< the control is the acceleration of the table
};

/// The control with a role. Where the scene does not name it, the one of its name beside `swept` comes first.
std::optional<SceneControl> control_near(const SceneSpec& scene, const SceneControl& swept,
                                         const char* role) {
  const auto control = control_of(scene, role);
  if (!control || find_named(scene.control_roles, role)->written) return control;
  const auto beside = find_control(scene, swept.part->name + "." + control->spec->name);
  return beside ? beside : control;
}

Result<GlidingScene> gliding_scene(const SceneSpec& scene, const std::string& name) {
  constexpr const char* kAcceleration = "table_acceleration";
  const auto control = name.empty() ? control_of(scene, kAcceleration) : find_control(scene, name);
  if (!control)
    return fail(Errc::UnknownName, name.empty() ? scene.file.text() : name,
                name.empty() ? fmt::format("no control has the role '{}'", kAcceleration)
                             : "no part has a control '" + name + "'",
                suggest(name, control_names(scene), "give one of the controls with --over"));
  const auto frequency = control_near(scene, *control, "table_frequency");
  const auto hertz = frequency ? frequency->constant() : std::nullopt;
  if (!hertz || !(*hertz > 0))
    return fail(Errc::Missing, control->part->at.text(), "the frequency of the table is not known",
                "give the role 'table_frequency' to a control with a constant value");
  const auto acceleration = control_near(scene, *control, kAcceleration);
  GlidingScene made{scene, control->name(), *hertz, acceleration && acceleration->name() == control->name()};
  auto& part = *find_named(made.scene.parts, control->part->name);
  const auto& key = control->spec->name;
  std::erase_if(part.wires, [&](const Field& field) { return field.key == key; });
  part.wires.push_back({key, part.at, Value{std::string{kGesture}, part.at}});
  made.scene.gestures.push_back({.name = kGesture, .at = part.at, .bare = true});
  made.scene.expect.clear();
  made.scene.ports.clear();
  made.scene.compare.reset();
  return made;
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

/// One run: the control glides to the first of some values and is held at each.
struct Glide {
  SceneSpec scene;
  std::vector<double> starts;  ///< of the values whose landings are read [s]
};

Glide glide_of(const GlidingScene& gliding, const BifurcationPlan& plan, int run) {
  Glide glide{gliding.scene, {}};
  auto& points = glide.scene.gestures.back().points = {{0, plan.from}};
  const int first = run * kColumnsOfARun;
  double time = kGlide_s;
  for (int i = std::max(0, first - kColumnsBefore); i < std::min(plan.values, first + kColumnsOfARun); ++i) {
    const double value = value_at(plan, i, plan.values);
    if (i >= first) glide.starts.push_back(time);
    points.push_back({time, value});
    points.push_back({time += plan.settling_s + plan.reading_s, value});
    time += kBifurcationSweepStep_s;
  }
  glide.scene.duration = Seconds{time};
  return glide;
}

/// Of each column the number of its landings, then the three numbers of each.
Checked<RunResult> play_glide(const Glide& glide, const NodeTable& table, const BifurcationPlan& plan) {
  const auto& scene = glide.scene;
  const auto recording = play_run({{}, scene}, table);
  if (!recording) return tl::unexpected(recording.error());
  const auto *ball = recording->find(signal_of(scene.roles, "ball")),
             *floor = recording->find(signal_of(scene.roles, "table"));
  if (ball == nullptr || floor == nullptr)
    return tl::unexpected(std::vector{Error{Errc::Missing, scene.file.text(),
                                            "the scene has no signals with the roles 'ball' and 'table'",
                                            "give two positions under [roles]"}});
  const auto landings = landings_of(ball->samples, floor->samples, recording->sample_rate);
  RunResult numbers;
  for (const double start : glide.starts) {
    const double from = start + plan.settling_s;
    const auto count = numbers.size();
    numbers.push_back(0);
    for (const auto& [time_s, speed, rebound] : landings) {
      if (!(time_s >= from && time_s < from + plan.reading_s)) continue;
      numbers.insert(numbers.end(), {time_s, speed, rebound});
      ++numbers[count];
    }
  }
  return numbers;
}

/// Adds the columns of a run; rebounds of landings in columns with period 1 to `rebounds`.
void add_columns(Bifurcation& found, const BifurcationPlan& plan, const RunResult& numbers,
                 std::vector<double>& rebounds) {
  for (auto at = numbers.begin(); at != numbers.end();) {
    auto& column = found.simulated.emplace_back();
    column.value = value_at(plan, static_cast<int>(found.simulated.size()) - 1, plan.values);
    std::vector<double> shares;
    for (double left = *at++; left > 0 && numbers.end() - at >= 3; --left, at += 3) {
      add(column, at[1], at[0] * found.frequency_hz);
      shares.push_back(at[2] / at[1]);
    }
    column.period = period_of(column.speeds);
    if (column.period == 1) rebounds.insert(rebounds.end(), shares.begin(), shares.end());
  }
}

}  // namespace

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
                                       const BifurcationPlan& plan) {
  const auto gliding = gliding_scene(scene, plan.control);
  if (!gliding) return tl::unexpected(std::vector{gliding.error()});
  Bifurcation found{scene.name, gliding->control, gliding->frequency_hz};
  found.runs = (plan.values + kColumnsOfARun - 1) / kColumnsOfARun;
  const auto key = fmt::format("bifurcation {} {} {} {}", plan.settling_s, plan.reading_s,
                               signal_of(scene.roles, "ball"), signal_of(scene.roles, "table"));
  const auto results = evaluate_runs(
      plan, static_cast<int>(found.runs),
      [&](int run) {
        return run_key(key, {{}, glide_of(*gliding, plan, run).scene});
      },
      [&](int run) { return play_glide(glide_of(*gliding, plan, run), table, plan); });
  if (!results) return tl::unexpected(results.error());
  found.finished = std::ranges::count_if(*results, [](const auto& run) { return run.has_value(); });
  if (found.finished < found.runs) return found;
  std::vector<double> rebounds;
  for (const auto& numbers : *results) add_columns(found, plan, *numbers, rebounds);
  found.measured_restitution = median(std::move(rebounds));
  found.restitution = plan.restitution.value_or(found.measured_restitution);
  if (!(found.restitution > 0 && found.restitution < 1) || !gliding->of_the_table) return found;
  found.exact = sweep_exactly(plan, found.restitution, found.frequency_hz);
  found.doublings = doublings_of(found);
  return found;
}

}  // namespace tactus
