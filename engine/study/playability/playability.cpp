#include "engine/study/playability/playability.h"

#include <algorithm>

namespace tactus {
namespace {

/// A judged run as numbers: the index of its kind, score, playable, readings.
std::vector<double> to_numbers(const JudgedRun& run, Playability::Kind kind) {
  const auto& kinds = run_kinds(kind);
  const auto found =
      std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.name == run.kind; });
  std::vector<double> numbers{static_cast<double>(found - kinds.begin()), run.score,
                              run.playable ? 1.0 : 0.0};
  numbers.insert(numbers.end(), run.readings.begin(), run.readings.end());
  return numbers;
}

/// Nothing if the numbers are not those of a judged run: a cache may be edited by hand.
std::optional<JudgedRun> from_numbers(const std::vector<double>& numbers, Playability::Kind kind) {
  const auto& kinds = run_kinds(kind);
  if (numbers.size() != 3 + measure_columns(kind).size() ||
      !(numbers[0] >= 0 && numbers[0] < static_cast<double>(kinds.size())))
    return std::nullopt;
  return JudgedRun{kinds[static_cast<std::size_t>(numbers[0])].name,
                   numbers[1],
                   numbers[2] != 0,
                   {numbers.begin() + 3, numbers.end()}};
}

}  // namespace

int PlayabilityStudy::finished() const {
  return static_cast<int>(
      std::count_if(runs.begin(), runs.end(), [](const PlayedRun& run) { return run.result.has_value(); }));
}

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
                                            const PlayabilityOptions& options) {
  if (!scene.playability)
    return tl::unexpected(
        std::vector{Error{Errc::Missing, scene.file.text(), "the scene has no [playability] section",
                          "add [playability] with kind = \"roll\" or kind = \"tone\""}});
  for (const auto& swept : options.over)
    if (auto status = check_swept(scene, swept); !status) return tl::unexpected(std::vector{status.error()});
  SweepPlan plan = options;
  plan.over.insert(plan.over.begin(), {"delay", {}, SweptValue::What::Delay});
  for (const double delay : options.delays_s) plan.over.front().values.emplace_back(delay);
  Sweep sweep{scene, table, plan};
  if (auto status = sweep.check(); !status) return tl::unexpected(status.error());
  const auto& rules = *scene.playability;
  const auto judge_run = [&](const Sweep::Run& run) -> Checked<std::vector<double>> {
    const auto recording = play_run(run, table);
    if (!recording) return tl::unexpected(recording.error());
    return to_numbers(judge(*recording, rules), rules.kind);
  };
  const auto points = sweep.evaluate(judge_run, "playability");
  if (!points) return tl::unexpected(points.error());
  PlayabilityStudy study{scene.name, rules.kind, options.delays_s, options.over, sweep.variants(), {}};
  for (const auto& point : *points)
    study.runs.push_back({point.at.front(),
                          {point.at.begin() + 1, point.at.end()},
                          point.variant,
                          point.result ? from_numbers(*point.result, rules.kind) : std::nullopt});
  return study;
}

}  // namespace tactus
