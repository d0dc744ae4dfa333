#include "engine/study/playability/playability_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/graph/file/quantity.h"
#include "engine/plot/cell_map.h"
#include "engine/plot/svg.h"
#include "engine/plot/svg_canvas.h"

namespace tactus {
namespace {

constexpr std::size_t kMostMaps = 12;

// From the best kind to the worst.
constexpr PlotColor kKindColors[] = {PlotColor::Green, PlotColor::Blue, PlotColor::Orange,
                                     PlotColor::Vermillion};

std::size_t kind_index(const PlayabilityStudy& study, const PlayedRun& run) {
  const auto& kinds = run_kinds(study.kind);
  const auto found =
      std::find_if(kinds.begin(), kinds.end(), [&](const RunKind& k) { return k.name == run.judged->kind; });
  return static_cast<std::size_t>(found - kinds.begin());
}

std::string fill_of(std::size_t kind) { return svg::shade(kKindColors[kind]).line; }

/// The reading that a map shows beside kind and score.
const MeasureColumn& main_reading(const PlayabilityStudy& study) {
  return measure_columns(study.kind).front();
}

double main_of(const PlayabilityStudy& study, const PlayedRun& run) {
  return run.judged->reading(study.kind, main_reading(study).name);
}

std::string subtitle_of(const PlayabilityStudy& study) {
  std::string text;
  for (const auto& kind : run_kinds(study.kind))
    text += fmt::format("{}{} {}: {}", text.empty() ? "" : "; ", kind.letter, kind.name, kind.doc);
  return text + ". Score: 0 nothing, 1 all that is wanted.";
}

// ---- nothing swept: curves

PlotPanel panel(const char* label, const char* unit) {
  PlotPanel made;
  made.y.label = label;
  made.y.unit = unit;
  return made;
}

/// One series for each kind that there is, over a grey line.
PlotPanel reading_panel(const PlayabilityStudy& study, const std::string& label,
                        const std::function<double(const PlayedRun&)>& value) {
  auto made = panel(label.c_str(), "");
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

PlotPanel robust_panel(const PlayabilityStudy& study) {
  auto made = panel("other actuators and plants that are playable", "");
  PlotSeries line{.mark = PlotMark::LineAndPoints, .color = PlotColor::Purple};
  for (const auto& verdict : study.verdicts()) {
    line.x.push_back(verdict.delay_s);
    line.y.push_back(verdict.robust());
  }
  made.series.push_back(std::move(line));
  made.levels.push_back({kRobustShare, "wanted"});
  made.y.low = 0;
  made.y.high = 1.05;
  return made;
}

Figure curves_of(const PlayabilityStudy& study) {
  Figure figure;
  figure.title = "Playability of " + study.scene;
  figure.subtitle = subtitle_of(study);
  figure.x = {.label = "delay", .unit = "s"};
  auto score = reading_panel(study, "score", [](const PlayedRun& run) { return run.judged->score; });
  score.y.high = 1.05;
  figure.panels.push_back(std::move(score));
  const auto& types = measure_columns(study.kind);
  for (const auto& type : types) {
    if (!type.drawn) continue;
    figure.panels.push_back(reading_panel(
        study, type.head, [&](const PlayedRun& run) { return run.judged->reading(study.kind, type.name); }));
  }
  if (study.variants.size() > 1) figure.panels.push_back(robust_panel(study));
  return figure;
}

// ---- maps

std::vector<std::string> names_of(const SweptValue& swept) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < swept.values.size(); ++i) names.push_back(value_in_words(swept, i));
  return names;
}

std::vector<CellMap::Key> kind_keys(const PlayabilityStudy& study) {
  std::vector<CellMap::Key> keys;
  const auto& kinds = run_kinds(study.kind);
  for (std::size_t k = 0; k < kinds.size(); ++k)
    keys.push_back({fill_of(k), fmt::format("{} {}", kinds[k].letter, kinds[k].name)});
  return keys;
}

CellMap::Cell kind_cell(const PlayabilityStudy& study, const PlayedRun& run) {
  const auto kind = kind_index(study, run);
  return {fill_of(kind), std::string(1, run_kinds(study.kind)[kind].letter)};
}

std::vector<CellMap::Key> ramp_keys(double most, int digits) {
  std::vector<CellMap::Key> keys;
  for (int i = 4; i >= 0; --i)
    keys.push_back({ramp_color(i / 4.0), fmt::format("{:.{}f}", most * i / 4.0, digits)});
  return keys;
}

const PlayedRun& run_at(const PlayabilityStudy& study, std::size_t delay, std::size_t a, std::size_t b) {
  const auto bs = study.over.size() > 1 ? study.over[1].values.size() : 1;
  const auto cell = (delay * study.over[0].values.size() + a) * bs + b;
  return study.runs[cell * study.variants.size()];
}

/// Delay across, what is swept upwards.
CellMap over_delay(const PlayabilityStudy& study, const std::string& title,
                   const std::function<CellMap::Cell(const PlayedRun&)>& cell) {
  CellMap map{title, "delay [ms]", study.over[0].name, {}, names_of(study.over[0]), {}, {}};
  for (const double delay : study.delays_s) map.x.push_back(fmt::format("{:g}", 1e3 * delay));
  for (std::size_t a = 0; a < map.y.size(); ++a)
    for (std::size_t d = 0; d < map.x.size(); ++d) map.cells.push_back(cell(run_at(study, d, a, 0)));
  return map;
}

CellPage maps_over_delay(const PlayabilityStudy& study) {
  CellPage page{"Playability of " + study.scene, subtitle_of(study), {}};
  double most = 0;
  for (const auto& run : study.runs) most = std::max(most, main_of(study, run));
  page.maps.push_back(over_delay(study, "kind", [&](const PlayedRun& run) { return kind_cell(study, run); }));
  page.maps.back().keys = kind_keys(study);
  page.maps.push_back(over_delay(
      study, "score", [](const PlayedRun& run) { return CellMap::Cell{ramp_color(run.judged->score)}; }));
  page.maps.back().keys = ramp_keys(1, 2);
  const auto& type = main_reading(study);
  page.maps.push_back(over_delay(study, type.head, [&](const PlayedRun& run) {
    return CellMap::Cell{ramp_color(most > 0 ? main_of(study, run) / most : 0)};
  }));
  page.maps.back().keys = ramp_keys(most, type.digits);
  return page;
}

/// One of the two across, the other upwards, for each of some delays.
CellPage maps_by_delay(const PlayabilityStudy& study) {
  CellPage page{"Playability of " + study.scene, subtitle_of(study), {}, 2};
  const auto delays = study.delays_s.size();
  const auto shown = std::min(delays, kMostMaps);
  for (std::size_t s = 0; s < shown; ++s) {
    const auto d = shown == 1 ? 0 : s * (delays - 1) / (shown - 1);
    CellMap map{fmt::format("{:g} ms", 1e3 * study.delays_s[d]),
                study.over[0].name,
                study.over[1].name,
                names_of(study.over[0]),
                names_of(study.over[1]),
                {},
                kind_keys(study)};
    for (std::size_t b = 0; b < map.y.size(); ++b)
      for (std::size_t a = 0; a < map.x.size(); ++a)
        map.cells.push_back(kind_cell(study, run_at(study, d, a, b)));
    page.maps.push_back(std::move(map));
  }
  return page;
}

}  // namespace

std::string value_in_words(const SweptValue& swept, std::size_t index) {
  const auto& value = swept.values[index];
  const auto digits = fmt::format("{:.3g}", value.si);
  if (swept.what == SweptValue::What::Scaled) return "x " + digits;
  return value.dimension ? short_quantity(std::stod(digits), *value.dimension) : digits;
}

Status write_picture(const std::filesystem::path& path, const PlayabilityStudy& study) {
  if (study.over.empty()) return write_svg(path, curves_of(study));
  return write_svg(path, study.over.size() == 1 ? maps_over_delay(study) : maps_by_delay(study));
}

}  // namespace tactus
