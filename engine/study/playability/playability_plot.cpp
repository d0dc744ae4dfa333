#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "engine/study/playability/playability.h"

namespace tactus {
namespace {

constexpr std::size_t kMostMaps = 12;

/// Kinds are in order from the best to the worst.
PlotColor color_of(std::size_t kind, std::size_t kinds) {
  constexpr PlotColor kBest[] = {PlotColor::Green, PlotColor::Blue, PlotColor::Sky};
  if (kind + 1 == kinds) return PlotColor::Vermillion;
  return kind + 2 == kinds ? PlotColor::Orange : kBest[kind];
}

using RunValue = std::function<double(const PlayedRun&)>;

double score_of(const PlayedRun& run) { return run.result->score; }
RunValue reading_at(std::size_t column) {
  return [column](const PlayedRun& run) { return run.result->readings[column]; };
}

std::string subtitle_of(const PlayabilityStudy& study) {
  std::string text;
  for (const auto& kind : run_kinds(study.kind))
    text += fmt::format("{}{} {}: {}", text.empty() ? "" : "; ", kind.letter, kind.name, kind.doc);
  return text + ". Score: 0 to 1 (ideal).";
}

// ---- nothing swept: curves

/// One series for each kind that there is, over a grey line.
Subplot value_subplot(const PlayabilityStudy& study, const std::string& label, const RunValue& value) {
  Subplot made{.y = {.label = label}};
  PlotSeries line{.color = PlotColor::Grey};
  std::vector<PlotSeries> kinds;
  for (std::size_t k = 0; k < run_kinds(study.kind).size(); ++k)
    kinds.push_back({.label = run_kinds(study.kind)[k].name,
                     .mark = PlotMark::Points,
                     .color = color_of(k, run_kinds(study.kind).size())});
  for (const auto& run : study.runs) {
    if (!run.as_written()) continue;
    for (auto* series : {&line, &kinds[study.kind_of(run)]}) {
      series->add(run.delay_s, value(run));
    }
  }
  if (std::ranges::all_of(line.y, [](double y) { return y >= 0; })) made.y.low = 0;
  made.series.push_back(std::move(line));
  for (auto& series : kinds)
    if (!series.x.empty()) made.series.push_back(std::move(series));
  return made;
}

Subplot robust_subplot(const PlayabilityStudy& study) {
  PlotSeries line{.mark = PlotMark::LineAndPoints, .color = PlotColor::Purple};
  for (const auto& verdict : study.verdicts()) {
    line.add(verdict.delay_s, verdict.robust());
  }
  return {.y = {.label = "variants of actuator and plant that are playable", .low = 0, .high = 1.05},
          .series = {std::move(line)},
          .levels = {{kRobustShare, "required"}}};
}

Plot curves_of(const PlayabilityStudy& study) {
  Plot plot{.title = "Playability of " + study.scene,
            .subtitle = subtitle_of(study),
            .x = {.label = "delay", .unit = "s"},
            .subplots = {value_subplot(study, "score", score_of)}};
  plot.subplots.front().y.high = 1.05;
  const auto& types = measure_columns(study.kind);
  for (std::size_t i = 0; i < types.size(); ++i)
    if (types[i].drawn) plot.subplots.push_back(value_subplot(study, types[i].head, reading_at(i)));
  if (study.variants.size() > 1) plot.subplots.push_back(robust_subplot(study));
  return plot;
}

// ---- maps

/// A map of the kind of runs: of `runs`, row by row.
PlotMap kind_map(const PlayabilityStudy& study, std::vector<std::string> columns,
                 std::vector<std::string> rows, const std::vector<const PlayedRun*>& runs) {
  PlotMap map{std::move(columns), std::move(rows), {}, {}};
  const auto& kinds = run_kinds(study.kind);
  for (const auto* run : runs) {
    const auto kind = study.kind_of(*run);
    map.cells.push_back(
        {.color = color_of(kind, kinds.size()), .letter = std::string(1, kinds[kind].letter)});
  }
  for (std::size_t k = 0; k < kinds.size(); ++k)
    map.keys.push_back(
        {{.color = color_of(k, kinds.size())}, fmt::format("{} {}", kinds[k].letter, kinds[k].name)});
  return map;
}

const PlayedRun& run_at(const PlayabilityStudy& study, std::size_t delay, std::size_t a, std::size_t b) {
  const auto bs = study.over.size() > 1 ? study.over[1].values.size() : 1;
  const auto cell = (delay * study.over[0].values.size() + a) * bs + b;
  return study.runs[cell * study.variants.size()];
}

/// Kind, score and main measure over the delay and one swept quantity.
Plot maps_over_delay(const PlayabilityStudy& study) {
  std::vector<std::string> delays;
  for (const double delay : study.delays_s) delays.push_back(fmt::format("{:g}", 1e3 * delay));
  const auto values = value_texts(study.over[0]);
  std::vector<const PlayedRun*> runs;
  for (std::size_t a = 0; a < values.size(); ++a)
    for (std::size_t d = 0; d < delays.size(); ++d) runs.push_back(&run_at(study, d, a, 0));
  const auto map_of = [&](const RunValue& value, std::optional<double> high) {
    std::vector<double> numbers;
    for (const auto* run : runs) numbers.push_back(value(*run));
    return value_map(delays, values, numbers, 0, high);
  };
  const auto head = [&](const std::string& what) {
    return PlotAxis{.label = what + ", against " + study.over[0].name};
  };
  return {
      .title = "Playability of " + study.scene,
      .subtitle = subtitle_of(study),
      .x = {.label = "delay [ms]"},
      .subplots = {{.y = head("kind"), .map = kind_map(study, delays, values, runs)},
                   {.y = head("score"), .map = map_of(score_of, 1)},
                   {.y = head(measure_columns(study.kind).front().head), .map = map_of(reading_at(0), {})}}};
}

/// The kind over two swept quantities, for several delays.
std::vector<Plot> maps_by_delay(const PlayabilityStudy& study) {
  std::vector<Plot> page;
  const auto delays = study.delays_s.size();
  const auto shown = std::min(delays, kMostMaps);
  for (std::size_t s = 0; s < shown; ++s) {
    const auto d = shown == 1 ? 0 : s * (delays - 1) / (shown - 1);
    std::vector<const PlayedRun*> runs;
    for (std::size_t b = 0; b < study.over[1].values.size(); ++b)
      for (std::size_t a = 0; a < study.over[0].values.size(); ++a) runs.push_back(&run_at(study, d, a, b));
    page.push_back(
        {.title = fmt::format("Playability of {}, {:g} ms", study.scene, 1e3 * study.delays_s[d]),
         .x = {.label = study.over[0].name},
         .subplots = {{.y = {.label = study.over[1].name},
                       .map = kind_map(study, value_texts(study.over[0]), value_texts(study.over[1]), runs)}},
         .width = 560});
  }
  return page;
}

}  // namespace

std::vector<Plot> plots_of(const PlayabilityStudy& study) {
  if (study.over.size() > 1) return maps_by_delay(study);
  return {study.over.empty() ? curves_of(study) : maps_over_delay(study)};
}

}  // namespace tactus
