#include "engine/study/orbits/bifurcation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "engine/core/median.h"
#include "engine/study/orbits/bifurcation_sweep.h"
#include "engine/study/orbits/bouncing_cascade.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus {
namespace {

constexpr double kGravity = 9.81;   // [m/s^2]
constexpr int kColumnsOfARun = 12;  // of the simulation; fixed, so that cores change nothing
constexpr int kColumnsBefore = 3;   // are played first and not read: a doubled orbit takes time to come apart
constexpr int kFittedColumns = 4;
constexpr int kFinerExactly = 4;      // the map costs next to nothing
constexpr int kExactSettling = 1500;  // bounces
constexpr int kExactRead = 64;

double value_at(const BifurcationPlan& plan, int i, int values) {
  return plan.from + (plan.to - plan.from) * i / (values - 1);
}

BifurcationColumn column_of(double value, const std::vector<Landing>& landings, double frequency) {
  BifurcationColumn column{value, {}, {}, 0};
  for (const auto& landing : landings) {
    column.speeds.push_back(landing.speed);
    const double turns = landing.time_s * frequency;
    column.phases.push_back(turns - std::floor(turns));
  }
  column.period = period_of(column.speeds);
  return column;
}

/// The ideal ball, from the orbit of one bounce a period on; nothing where that is not there to begin with.
std::vector<BifurcationColumn> sweep_exactly(const BifurcationPlan& plan, double e, double frequency) {
  std::vector<BifurcationColumn> columns;
  if (plan.from <= BouncingBall::orbit_begins(1, e)) return columns;
  auto bounce = BouncingBall{plan.from, e}.orbit(1);
  const int values = kFinerExactly * (plan.values - 1) + 1;
  const double metre_per_s = kGravity / (2 * std::numbers::pi * frequency);
  for (int i = 0; i < values; ++i) {
    const double gamma = value_at(plan, i, values);
    const BouncingBall ball{gamma, e};
    BifurcationColumn column{gamma, {}, {}, 0};
    for (int n = 0; n < kExactSettling + kExactRead; ++n) {
      bounce.phase = std::fmod(bounce.phase, 2 * std::numbers::pi);
      bounce = ball.next(bounce);
      if (n < kExactSettling) continue;
      // It leaves as fast as it came, times e.
      column.speeds.push_back((bounce.speed - gamma * std::cos(bounce.phase)) / e * metre_per_s);
      const double turns = bounce.phase / (2 * std::numbers::pi);
      column.phases.push_back(turns - std::floor(turns));
    }
    column.period = period_of(column.speeds);
    columns.push_back(std::move(column));
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

}  // namespace

std::optional<double> doubling_in(const std::vector<BifurcationColumn>& columns, int bounces) {
  const auto behind =
      std::find_if(columns.begin(), columns.end(), [&](const auto& c) { return c.period == 2 * bounces; });
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
  const auto sweep = SceneSweep::make(scene, table, plan);
  if (!sweep) return tl::unexpected(sweep.error());
  Bifurcation found{scene.name, plan.control, sweep->frequency(), 0, 0, {}, {}, {}};
  const int runs = (plan.values + kColumnsOfARun - 1) / kColumnsOfARun;
  std::vector<SweepResult> results(static_cast<std::size_t>(runs));
  const auto run = [&](int r) {
    const int first = r * kColumnsOfARun, before = std::min(first, kColumnsBefore);
    std::vector<double> values;
    for (int i = first - before; i < std::min(plan.values, first + kColumnsOfARun); ++i)
      values.push_back(value_at(plan, i, plan.values));
    auto& result = results[static_cast<std::size_t>(r)] = sweep->run(values);
    if (result) result->erase(result->begin(), result->begin() + before);
  };
  parallel_for(
      runs, run, progress ? progress : [](double) {});
  std::vector<double> rebounds;
  for (const auto& result : results) {
    if (!result) return tl::unexpected(std::vector{result.error()});
    for (const auto& held : *result) {
      found.simulated.push_back(column_of(held.value, held.landings, found.frequency_hz));
      if (found.simulated.back().period == 1)
        for (const auto& landing : held.landings) rebounds.push_back(landing.rebound / landing.speed);
    }
  }
  found.measured_restitution = median(std::move(rebounds));
  found.restitution = plan.restitution.value_or(found.measured_restitution);
  if (!(found.restitution > 0 && found.restitution < 1) || !sweep->of_the_table()) return found;
  found.exact = sweep_exactly(plan, found.restitution, found.frequency_hz);
  found.doublings = doublings_of(found);
  return found;
}

}  // namespace tactus
