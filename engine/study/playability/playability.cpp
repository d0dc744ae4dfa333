#include "engine/study/playability/playability.h"

#include <algorithm>

#include "engine/core/named.h"

namespace tactus {
namespace {

std::size_t kind_index(const PlayabilityResult& run, Playability::Kind kind) {
  const auto& kinds = run_kinds(kind);
  return static_cast<std::size_t>(std::ranges::find(kinds, run.kind, &RunKind::name) - kinds.begin());
}

/// A run as numbers: the index of its kind, score, playable, readings.
RunResult to_numbers(const PlayabilityResult& run, Playability::Kind kind) {
  RunResult numbers{static_cast<double>(kind_index(run, kind)), run.score, run.playable ? 1.0 : 0.0};
  numbers.insert(numbers.end(), run.readings.begin(), run.readings.end());
  return numbers;
}

/// nullopt if the numbers are not those of a run: a cache may be edited by hand.
std::optional<PlayabilityResult> from_numbers(const RunResult& numbers, Playability::Kind kind) {
  const auto& kinds = run_kinds(kind);
  if (numbers.size() != 3 + measure_columns(kind).size() ||
      !(numbers[0] >= 0 && numbers[0] < static_cast<double>(kinds.size())))
    return std::nullopt;
  return PlayabilityResult{kinds[static_cast<std::size_t>(numbers[0])].name,
                           numbers[1],
                           numbers[2] != 0,
                           {numbers.begin() + 3, numbers.end()}};
}

}  // namespace

std::size_t PlayabilityStudy::kind_of(const PlayedRun& run) const { return kind_index(*run.result, kind); }

std::vector<DelayVerdict> PlayabilityStudy::verdicts() const {
  std::vector<DelayVerdict> verdicts;
  for (std::size_t d = 0; d < delays_s.size(); ++d) {
    DelayVerdict verdict{.delay_s = delays_s[d], .worst = d * runs_a_delay()};
    for (std::size_t i = verdict.worst; i < (d + 1) * runs_a_delay(); ++i) {
      const auto& result = *runs[i].result;
      (runs[i].as_written() ? verdict.runs : verdict.varied) += 1;
      (runs[i].as_written() ? verdict.good : verdict.varied_good) += result.playable ? 1 : 0;
      if (!runs[i].as_written()) continue;
      verdict.score += result.score;
      if (result.score < runs[verdict.worst].result->score) verdict.worst = i;
    }
    verdict.score /= verdict.runs;
    verdict.playable = verdict.good == verdict.runs && verdict.robust() >= kRobustShare;
    verdicts.push_back(verdict);
  }
  return verdicts;
}

Checked<PlayabilityStudy> study_playability(const SceneSpec& scene, const NodeTable& table,
                                            const SweepPlan& plan) {
  if (!scene.playability)
    return tl::unexpected(
        std::vector{Error{Errc::Missing, scene.file.text(), "the scene has no [playability] section",
                          "add [playability] with kind = \"roll\" or kind = \"tone\""}});
  Sweep sweep{scene, table, plan};
  if (auto status = sweep.check(); !status) return tl::unexpected(status.error());
  const auto& rules = *scene.playability;
  const auto score_run = [&](const Sweep::Run& run) -> Checked<RunResult> {
    const auto recording = play_run(run, table);
    if (!recording) return tl::unexpected(recording.error());
    return to_numbers(evaluate(*recording, rules), rules.kind);
  };
  const auto points = sweep.evaluate(score_run, "playability");
  if (!points) return tl::unexpected(points.error());
  PlayabilityStudy study{
      scene.name, rules.kind, {}, {plan.over.begin() + 1, plan.over.end()}, names_of(sweep.variants()), {}};
  for (const auto& delay : plan.over.front().values) study.delays_s.push_back(delay.si);
  for (const auto& point : *points)
    study.runs.push_back({{{point.at.begin() + 1, point.at.end()},
                           point.variant,
                           point.result ? from_numbers(*point.result, rules.kind) : std::nullopt},
                          point.at.front()});
  return study;
}

}  // namespace tactus
