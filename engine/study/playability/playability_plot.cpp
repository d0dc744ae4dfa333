#include "engine/study/playability/playability_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/plot/plot.h"

namespace tactus {
namespace {

constexpr std::size_t kMostMaps = 12;

// From the best kind to the worst.
constexpr PlotColor kKindColors[] = {PlotColor::Green, PlotColor::Blue, PlotColor::Orange,
                                     PlotColor::Vermillion};

std::size_t kind_index(const PlayabilityStudy& study, const PlayedRun& run) {
  const auto& kinds = run_kinds(study.kind);
  const auto found =
      std::find_if(kinds.begin(), kinds.end(), [&](const RunKind& k) { return k.name == run.result->kind; });
  return static_cast<std::size_t>(found - kinds.begin());
}

/// The reading that a map shows beside kind and score.
const MeasureColumn& main_reading(const PlayabilityStudy& study) {
  return measure_columns(study.kind).front();
}

double main_of(const PlayabilityStudy& study, const PlayedRun& run) {
  return run.result->reading(study.kind, main_reading(study).name);
}

std::string subtitle_of(const PlayabilityStudy& study) {
  std::string text;
  for (const auto& kind : run_kinds(study.kind))
    text += fmt::format("{}{} {}: {}", text.empty() ? "" : "; ", kind.letter, kind.name, kind.doc);
  return text + ". Score: 0 nothing, 1 ideal.";
}

// ---- nothing swept: curves

Subplot subplot(const char* label, const char* unit) {
  Subplot made;
  made.y.label = label;
  made.y.unit = unit;
  return made;
}

/// One series for each kind that there is, over a grey line.
Subplot reading_subplot(const PlayabilityStudy& study, const std::string& label,
                        const std::function<double(const PlayedRun&)>& value) {
  auto made = subplot(label.c_str(), "");
  PlotSeries line;
  line.color = PlotColor::Grey;
  std::vector<PlotSeries> points;
  for (std::size_t k = 0; k < run_kinds(study.kind).size(); ++k)
    points.push_back(
        {.label = run_kinds(study.kind)[k].name, .mark = PlotMark::Points, .color = kKindColors[k]});
  for (const auto& run : study.runs) {
    if (!run.as_written()) continue;
    line.x.push_back(run.delay_s);
    line.y.push_back(value(run));
    auto& series = points[kind_index(study, run)];
    series.x.push_back(run.delay_s);
    series.y.push_back(value(run));
  }
  const auto line_low = line.y;
  made.series.push_back(std::move(line));
  for (auto& series : points)
    if (!series.x.empty()) made.series.push_back(std::move(series));
  if (std::all_of(line_low.begin(), line_low.end(), [](double y) { return y >= 0; })) made.y.low = 0;
  return made;
}

Subplot robust_subplot(const PlayabilityStudy& study) {
  auto made = subplot("other actuators and plants that are playable", "");
  PlotSeries line{.mark = PlotMark::LineAndPoints, .color = PlotColor::Purple};
  for (const auto& verdict : study.verdicts()) {
    line.x.push_back(verdict.delay_s);
    line.y.push_back(verdict.robust());
  }
  made.series.push_back(std::move(line));
  made.levels.push_back({kRobustShare, "required"});
  made.y.low = 0;
  made.y.high = 1.05;
  return made;
}

Plot curves_of(const PlayabilityStudy& study) {
  Plot plot;
  plot.title = "Playability of " + study.scene;
  plot.subtitle = subtitle_of(study);
  plot.x = {.label = "delay", .unit = "s"};
  auto score = reading_subplot(study, "score", [](const PlayedRun& run) { return run.result->score; });
  score.y.high = 1.05;
  plot.subplots.push_back(std::move(score));
  const auto& types = measure_columns(study.kind);
  for (const auto& type : types) {
    if (!type.drawn) continue;
    plot.subplots.push_back(reading_subplot(
        study, type.head, [&](const PlayedRun& run) { return run.result->reading(study.kind, type.name); }));
  }
  if (study.variants.size() > 1) plot.subplots.push_back(robust_subplot(study));
  return plot;
}

// ---- maps

std::vector<std::string> names_of(const SweptValue& swept) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < swept.values.size(); ++i) names.push_back(value_text(swept, i));
  return names;
}

PlotMap::Cell kind_cell(const PlayabilityStudy& study, const PlayedRun& run) {
  const auto kind = kind_index(study, run);
  return {.color = kKindColors[kind], .letter = std::string(1, run_kinds(study.kind)[kind].letter)};
}

/// A map of the kind of runs: of `runs`, row by row.
PlotMap kind_map(const PlayabilityStudy& study, std::vector<std::string> columns,
                 std::vector<std::string> rows, const std::vector<const PlayedRun*>& runs) {
  PlotMap map{std::move(columns), std::move(rows), {}, {}};
  for (const auto* run : runs) map.cells.push_back(kind_cell(study, *run));
  const auto& kinds = run_kinds(study.kind);
  for (std::size_t k = 0; k < kinds.size(); ++k)
    map.keys.push_back({{.color = kKindColors[k]}, fmt::format("{} {}", kinds[k].letter, kinds[k].name)});
  return map;
}

const PlayedRun& run_at(const PlayabilityStudy& study, std::size_t delay, std::size_t a, std::size_t b) {
  const auto bs = study.over.size() > 1 ? study.over[1].values.size() : 1;
  const auto cell = (delay * study.over[0].values.size() + a) * bs + b;
  return study.runs[cell * study.variants.size()];
}

/// Kind, score and main reading over the delay and one swept quantity.
Plot maps_over_delay(const PlayabilityStudy& study) {
  std::vector<std::string> delays;
  for (const double delay : study.delays_s) delays.push_back(fmt::format("{:g}", 1e3 * delay));
  const auto values = names_of(study.over[0]);
  std::vector<const PlayedRun*> runs;
  std::vector<double> scores, readings;
  for (std::size_t a = 0; a < values.size(); ++a)
    for (std::size_t d = 0; d < delays.size(); ++d) {
      runs.push_back(&run_at(study, d, a, 0));
      scores.push_back(runs.back()->result->score);
      readings.push_back(main_of(study, *runs.back()));
    }
  const auto head = [&](const std::string& what) {
    return PlotAxis{.label = what + ", over " + study.over[0].name};
  };
  return {.title = "Playability of " + study.scene,
          .subtitle = subtitle_of(study),
          .x = {.label = "delay [ms]"},
          .subplots = {{.y = head("kind"), .map = kind_map(study, delays, values, runs)},
                       {.y = head("score"), .map = value_map(delays, values, scores, 0, 1)},
                       {.y = head(main_reading(study).head), .map = value_map(delays, values, readings, 0)}}};
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
                       .map = kind_map(study, names_of(study.over[0]), names_of(study.over[1]), runs)}},
         .width = 560});
  }
  return page;
}

}  // namespace

Status write_picture(const std::filesystem::path& path, const PlayabilityStudy& study) {
  if (study.over.size() > 1) return write_svg(path, maps_by_delay(study), 2);
  return write_svg(path, {study.over.empty() ? curves_of(study) : maps_over_delay(study)});
}

}  // namespace tactus
