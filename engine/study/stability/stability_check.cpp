#include "engine/study/stability/stability_check.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "engine/core/index.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus {
namespace {

/// At rest. What inputs and gestures do is in the verdict already.
Stability predicted(const StabilitySubject& subject, const StabilityOptions& options,
                    const StabilityVerdict& verdict, const ExtremePlan& plan) {
  for (const auto& control : verdict.controls)
    for (const bool low : {true, false})
      if (const auto set = plan.world.set.find(control.control.name);
          plan.elsewhere && set != plan.world.set.end() && plan.control == control.control.name &&
          set->second.si == (low ? control.control.range.low : control.control.range.high))
        return (low ? control.stable_low : control.stable_high) ? Stability::Stable : Stability::Unstable;
  return stability_with(subject, plan.world, options.push);
}

/// Predicts the stability where each run takes it, and measures it there.
Checked<std::vector<ExtremeRun>> run_all(const StabilitySubject& subject, const StabilityOptions& options,
                                         const StabilityVerdict& verdict,
                                         const std::function<void(double)>& progress, int workers) {
  const auto world = RestingWorld::make(subject, options.world);
  if (!world) return tl::unexpected(world.error());
  auto plans = border_runs(options.world, verdict);
  for (auto& plan : extremes_of(options.world, world->instrument())) plans.push_back(std::move(plan));
  // A quarter of a run lasts a whole turn of the slowest oscillation, whose energy comes and goes twice in
  // it.
  constexpr double kShortest = 0.5, kLongest = 4;
  double slowest = std::numeric_limits<double>::infinity();
  for (const auto& root : verdict.regimes.front().roots)
    if (root.frequency_hz > 0) slowest = std::min(slowest, root.frequency_hz);
  for (auto& plan : plans) {
    if (!plan.linear) plan.seconds = std::clamp(4 / slowest, kShortest, kLongest);
    if (plan.elsewhere) plan.world = without_gestures(plan.world, verdict);
  }
  std::vector<std::optional<Checked<ExtremeRun>>> made(plans.size());
  const auto run_one = [&](int i) {
    auto& plan = plans[index(i)];
    // At another rate a graph may have a loop without a delay.
    if (plan.elsewhere && !build_world(subject, plan.world)) return;
    auto& run = made[index(i)].emplace(run_extreme(subject, plan));
    // What is bounded contradicts no prediction.
    if (!plan.linear && run && !run->bounded())
      run->expected = predicted(subject, options, verdict, plan) == Stability::Stable;
  };
  parallel_for(static_cast<int>(plans.size()), run_one, progress, workers);
  std::vector<ExtremeRun> runs;
  for (auto& run : made) {
    if (!run) continue;
    if (!*run) return tl::unexpected(run->error());
    runs.push_back(std::move(**run));
  }
  exclude_player_energy(runs);
  return runs;
}

/// Runs that went as predicted decide what they can.
void settle(StabilityReport& report) {
  auto& verdict = report.verdict;
  if (!std::ranges::all_of(report.runs, &ExtremeRun::as_expected)) return;
  std::erase_if(verdict.doubts, [](const Doubt& doubt) { return doubt.until_played; });
  const bool undecided = !verdict.doubts.empty() || verdict.has_undecided_part();
  if (verdict.stability == Stability::Undecided && !undecided) verdict.stability = Stability::Stable;
}

}  // namespace

Stability StabilityReport::stability() const {
  auto all = verdict.stability;
  for (const auto& run : runs)
    if (!run.as_expected()) all = worse(all, run.elsewhere ? Stability::Undecided : Stability::Unstable);
  return all;
}

Checked<StabilityReport> check_stability(const StabilitySubject& subject, const StabilityOptions& options,
                                         bool quick, const StabilityProgress& progress, int workers) {
  const auto doing = [&](const char* what) {
    return [&progress, what](double share) {
      if (progress) progress(what, share);
    };
  };
  auto verdict = analyse_stability(subject, options, doing("analysing the loops"), workers);
  if (!verdict) return tl::unexpected(verdict.error());
  StabilityReport report{std::move(*verdict), {}};
  if (quick) return report;
  auto runs = run_all(subject, options, report.verdict, doing("running"), workers);
  if (!runs) return tl::unexpected(runs.error());
  report.runs = std::move(*runs);
  settle(report);
  return report;
}

}  // namespace tactus
