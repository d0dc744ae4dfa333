#include <fmt/format.h>

#include <algorithm>

#include "apps/study/study.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

std::string ms(double seconds) { return fmt::format("{:.4g}", 1e3 * seconds); }

// ---- the table

std::vector<std::string> head(const PlayabilityStudy& study) {
  std::vector<std::string> names{"delay ms", "playable", "score", "kind"};
  for (const auto& type : measure_columns(study.kind)) names.push_back(type.head);
  if (study.variants.size() > 1) names.emplace_back("others");
  if (!study.over.empty()) names.emplace_back("worst at");
  return names;
}

std::vector<std::string> row(const PlayabilityStudy& study, const DelayVerdict& verdict) {
  const auto& run = study.runs[verdict.worst];
  std::vector<std::string> cells{ms(verdict.delay_s), verdict.playable ? "yes" : "no",
                                 fmt::format("{:.2f}", verdict.score), run.result->kind};
  const auto& types = measure_columns(study.kind);
  for (std::size_t i = 0; i < types.size(); ++i)
    cells.push_back(fmt::format("{:.{}f}", run.result->readings[i], types[i].digits));
  if (study.variants.size() > 1) cells.push_back(fmt::format("{}/{}", verdict.varied_good, verdict.varied));
  if (!study.over.empty()) cells.push_back(setting_text(study.over, run.at));
  return cells;
}

/// The maps of its plots as letters, and what they mean.
std::string maps_text(const PlayabilityStudy& study) {
  std::string text;
  const auto& upwards = study.over.back().name;
  for (const auto& plot : plots_of(study)) {
    const auto& map = *plot.subplots.front().map;
    std::size_t widest = upwards.size();
    for (const auto& row : map.rows) widest = std::max(widest, row.size());
    text += fmt::format("\n{}\n{:>{}}  {} {} to {}\n", plot.title, upwards, widest, plot.x.label,
                        map.columns.front(), map.columns.back());
    for (std::size_t row = map.rows.size(); row-- > 0; text += "\n") {
      text += fmt::format("{:>{}}  ", map.rows[row], widest);
      for (std::size_t column = 0; column < map.columns.size(); ++column)
        text += map.cells[row * map.columns.size() + column].letter;
    }
  }
  for (const auto& kind : run_kinds(study.kind))
    text += fmt::format("  {}  {}: {}\n", kind.letter, kind.name, kind.doc);
  return text;
}

// ---- the verdict

/// "0 to 7 and 11 to 40 ms": delays at which it is playable, or not.
std::string ranges(const std::vector<DelayVerdict>& verdicts, bool playable) {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < verdicts.size();) {
    auto end = i;
    while (end + 1 < verdicts.size() && verdicts[end + 1].playable == verdicts[i].playable) ++end;
    if (verdicts[i].playable == playable)
      found.push_back(end == i ? "at " + ms(verdicts[i].delay_s)
                               : "from " + ms(verdicts[i].delay_s) + " to " + ms(verdicts[end].delay_s));
    i = end + 1;
  }
  const auto last = found.back();
  found.pop_back();
  return fmt::format("{}{}{} ms", fmt::join(found, ", "), found.empty() ? "" : " and ", last);
}

std::string lacking(const PlayabilityStudy& study, const DelayVerdict& verdict) {
  const auto& run = study.runs[verdict.worst];
  auto text = fmt::format("{}, score {:.2f}", run.result->kind, run.result->score);
  if (study.over.empty() && verdict.varied == 0) return text;
  if (!study.over.empty()) text += " at " + setting_text(study.over, run.at);
  if (verdict.varied > 0)
    text += fmt::format("; {} of {} variants of actuator and plant", verdict.varied_good, verdict.varied);
  return text;
}

/// The settings, as runs at the first delay, that are not playable at some delay.
std::vector<const PlayedRun*> failing_settings(const PlayabilityStudy& study) {
  std::vector<const PlayedRun*> failing;
  for (std::size_t i = 0; i < study.runs_a_delay(); i += study.variants.size()) {
    bool playable = true;
    for (std::size_t d = 0; d < study.delays_s.size(); ++d)
      playable &= study.runs[d * study.runs_a_delay() + i].result->playable;
    if (!playable) failing.push_back(&study.runs[i]);
  }
  return failing;
}

/// "48 of 49 settings are playable at every delay, not weight x 3.2, stroke x 0.2; 146 of 147 runs; all 49
/// from 0 to 20 ms"; `where`: the delays at which all are, or nothing.
std::string describe_settings(const PlayabilityStudy& study, const std::string& where) {
  constexpr std::size_t kMostNamed = 3;
  const auto failing = failing_settings(study);
  const auto count = study.runs_a_delay() / study.variants.size();
  if (failing.empty()) return fmt::format("all {} settings are playable {}", count, where);
  auto text = failing.size() == count
                  ? fmt::format("none of the {} settings is playable at every delay", count)
                  : fmt::format("{} of {} settings are playable at every delay, except ",
                                count - failing.size(), count);
  for (std::size_t i = 0; failing.size() < count && i < std::min(failing.size(), kMostNamed); ++i)
    text += (i == 0 ? "" : " / ") + setting_text(study.over, failing[i]->at);
  if (failing.size() < count && failing.size() > kMostNamed)
    text += fmt::format(" and {} more", failing.size() - kMostNamed);
  const auto good = std::count_if(study.runs.begin(), study.runs.end(),
                                  [](const auto& run) { return run.as_written() && run.result->playable; });
  text += fmt::format("; {} of {} runs", good, count * study.delays_s.size());
  return where.empty() ? text : text + fmt::format("; all {} {}", count, where);
}

Json verdict_json(const DelayVerdict& verdict) {
  return {{"delay_s", verdict.delay_s},
          {"playable", verdict.playable},
          {"score", verdict.score},
          {"runs", verdict.runs},
          {"playable_runs", verdict.good},
          {"varied_runs", verdict.varied},
          {"playable_varied_runs", verdict.varied_good}};
}

}  // namespace

std::string describe_verdict(const PlayabilityStudy& study) {
  const auto verdicts = study.verdicts();
  const auto weaker = [](const DelayVerdict& a, const DelayVerdict& b) {
    if (a.playable != b.playable) return !a.playable;
    return a.score * a.robust() < b.score * b.robust();
  };
  const auto weakest = std::min_element(verdicts.begin(), verdicts.end(), weaker);
  const bool some = std::any_of(verdicts.begin(), verdicts.end(), [](const auto& v) { return v.playable; });
  const auto where = some ? ranges(verdicts, true) : std::string{};
  auto text = !study.over.empty() ? describe_settings(study, where)
                                  : "playable " + (some ? where : std::string{"at no delay"});
  if (study.over.empty() && some && !weakest->playable) text += "; not " + ranges(verdicts, false);
  return text + fmt::format("; weakest at {} ms: {}", ms(weakest->delay_s), lacking(study, *weakest));
}

std::string text_of(const PlayabilityStudy& study) {
  Table table{{head(study)}};
  for (const auto& verdict : study.verdicts()) table.rows.push_back(row(study, verdict));
  return study.scene + "\n\n" + table.text() + (study.over.empty() ? "" : maps_text(study)) + "\n" +
         describe_verdict(study) + "\n";
}

Json json_of(const PlayabilityStudy& study) {
  Json json{{"scene", study.scene},
            {"kind", study.kind == Playability::Kind::Roll ? "roll" : "tone"},
            {"verdict", describe_verdict(study)},
            {"over", list_of(study.over, [](const SweptValue& swept) { return swept.name; })},
            {"delays", list_of(study.verdicts(), verdict_json)},
            {"runs", Json::array()}};
  const auto& types = measure_columns(study.kind);
  for (const auto& run : study.runs) {
    Json entry{{"delay_s", run.delay_s}};
    for (std::size_t i = 0; i < run.at.size(); ++i) entry[study.over[i].name] = run.at[i];
    entry["variant"] = run.variant;
    entry["kind"] = run.result->kind;
    entry["score"] = run.result->score;
    entry["playable"] = run.result->playable;
    for (std::size_t i = 0; i < types.size(); ++i) entry[types[i].name] = run.result->readings[i];
    json["runs"].push_back(std::move(entry));
  }
  return json;
}

namespace {

struct PlayabilityArguments : SweepOptions {
  std::string delay = "0:40:1 ms";
};

SweptValue delays_of(const std::string& text) {
  SweptValue delays{"delay", parse_steps(text, "--delays"), SweptValue::What::Delay};
  for (const auto& value : delays.values) {
    if (!value.dimension || !(*value.dimension == Dimension{.second = 1}))
      exit_with({Errc::UnitMismatch, "--delays", "'" + text + "' is not a time or a range of times",
                 "write for instance \"0:40:1 ms\""});
    if (value.si < 0 || value.si > 1)
      exit_with({Errc::OutOfRange, "--delays", "a delay of " + fmt::format("{:g} s", value.si),
                 "choose 0 s to 1 s"});
  }
  return delays;
}

SweepPlan study_plan(const PlayabilityArguments& options, SceneSpec& scene) {
  if (options.over.size() > 2)
    exit_with({Errc::BadArgument, "--over", "at most two parameters can be swept in addition to the delay",
               "use tactus sweep for more"});
  auto plan = read_plan(options, scene);
  const double least_s = scene.playability ? scene.playability->from_s + 1 : 1;
  if (!options.duration.empty() && scene.duration.value < least_s)
    exit_with({Errc::OutOfRange, "--duration", "leaves less than one second to evaluate",
               fmt::format("choose at least {:g} s", least_s)});
  if (std::ranges::find(plan.over, SweptValue::What::Delay, &SweptValue::what) != plan.over.end())
    exit_with({Errc::BadArgument, "--over", "the delay is swept already", "use --delays"});
  plan.over.insert(plan.over.begin(), delays_of(options.delay));
  return plan;
}

int run_playability(const PlayabilityArguments& options) {
  auto scene = load_target(options);
  auto plan = study_plan(options, scene);
  SweepMonitor monitor{scene.name, plan};
  const auto study = or_exit(study_playability(scene, standard_nodes(), plan));
  if (const auto exit = monitor.end(finished(study.runs), std::ssize(study.runs))) return *exit;
  publish(options, text_of(study), json_of(study), plots_of(study), study.over.size() > 1 ? 2 : 1);
  const auto verdicts = study.verdicts();
  return std::all_of(verdicts.begin(), verdicts.end(), [](const auto& v) { return v.playable; }) ? kDone
                                                                                                 : kNo;
}

}  // namespace

void add_study_playability(CLI::App& study, int& exit_code) {
  auto [command, options] = add_command(
      study, "playability", "Playability of a scene as a function of the delay", exit_code, run_playability);
  add_study_options(command, options, "scene with a [playability] section; for a folder, its scene.toml")
      ->required();
  command
      .add_option("--delays", options.delay, "system delays; to simulate: FROM:TO:STEP, or a single value")
      ->capture_default_str();
  add_sweep_options(command, options);
  command.footer(
      "Examples:\n  tactus study playability instruments/haptic_drum\n  tactus study playability "
      "instruments/haptic_drum --over strength=0.2:1:5 --svg drum.svg\n  tactus study playability "
      "instruments/haptic_drum --delays \"20 ms\" --gain \"6 dB\" --draws 50\n  tactus study playability "
      "instruments/cellomobo/open_string.toml --delays \"0:40:5 ms\" --over \"tuned=55:880:5:log Hz\"\nThe "
      "criteria are in [playability] of the scene; see docs/playability.md.\nExit code 1: not playable at "
      "one or more delays. 5: interrupted.");
}

}  // namespace tactus::app
