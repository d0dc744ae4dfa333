#include "engine/study/stability/stability_check.h"

#include <algorithm>
#include <utility>

#include "engine/core/index.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus {
namespace {

/// Predicts the stability where each run takes it, and measures it there.
Checked<std::vector<ExtremeRun>> run_all(const StabilitySubject& subject, const StabilityOptions& options,
                                         const StabilityVerdict& verdict,
                                         const std::function<void(double)>& progress, int workers) {
  const auto world = RestingWorld::make(subject, options.world);
  if (!world) return tl::unexpected(world.error());
  auto plans = border_runs(options.world, verdict);
  for (auto& plan : extremes_of(options.world, world->instrument())) plans.push_back(std::move(plan));
  std::vector<Checked<ExtremeRun>> made(plans.size());
  const auto run_one = [&](int i) {
    auto& plan = plans[index(i)];
    if (!plan.linear)
      plan.expected = stability_with(subject, plan.world, options.push) == Stability::Stable;
    made[index(i)] = run_extreme(subject, plan);
  };
  parallel_for(static_cast<int>(plans.size()), run_one, progress, workers);
  std::vector<ExtremeRun> runs;
  for (auto& run : made) {
    if (!run) return tl::unexpected(run.error());
    runs.push_back(std::move(*run));
  }
  exclude_player_energy(runs);
  return runs;
}

}  // namespace

Stability StabilityReport::stability() const {
  const bool as_predicted = std::ranges::all_of(runs, &ExtremeRun::as_expected);
  return as_predicted ? verdict.stability : Stability::Unstable;
}

Checked<StabilityReport> check_stability(const StabilitySubject& subject, const StabilityOptions& options,
                                         bool quick, const StabilityProgress& progress, int workers) {
  const auto doing = [&](const char* what) {
    return [&progress, what](double share) {
      if (progress) progress(what, share);
    };
  };
  auto verdict = analyse_stability(subject, options, doing("analysing the loops"));
  if (!verdict) return tl::unexpected(verdict.error());
  StabilityReport report{std::move(*verdict), {}};
  if (quick) return report;
  auto runs = run_all(subject, options, report.verdict, doing("running"), workers);
  if (!runs) return tl::unexpected(runs.error());
  report.runs = std::move(*runs);
  return report;
}

}  // namespace tactus
