#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "apps/cli/json.h"
#include "engine/plot/plot.h"
#include "engine/study/orbits/bifurcation.h"
#include "engine/study/playability/playability.h"
#include "engine/study/walls/wall_map.h"
#include "engine/study/work_precision/work_precision.h"

namespace tactus::app {

/// Text in columns of equal width, aligned to the right; the first row is the head.
struct Table {
  std::vector<std::vector<std::string>> rows;

  std::string text() const;
  /// The same as a table of Markdown.
  std::string markdown() const;
};

// Reports of complete studies as text, JSON and plots.

std::string text_of(const Bifurcation& study);
Json json_of(const Bifurcation& study);
std::vector<Plot> plots_of(const Bifurcation& study);

/// A row per setting: swept values, then measures.
std::string text_of(const SweepTable& table);
Json json_of(const SweepTable& table);

/// One line per delay: score, kind, measures; if something is swept, also maps of letters; the verdict.
std::string text_of(const PlayabilityStudy& study);
Json json_of(const PlayabilityStudy& study);
/// "playable from 0 to 40 ms; weakest at 23 ms: irregular, score 0.61"
std::string describe_verdict(const PlayabilityStudy& study);

/// The largest stiffness over the delay, over the rate, and of each controller.
std::string text_of(const WallMap& map);
Json json_of(const WallMap& map);
std::vector<Plot> plots_of(const WallMap& map);

/// One line per variant, by computing time; the references of the errors; the cheapest variants for 1 % and
/// for 0.01 %.
std::string text_of(const WorkPrecision& study);
/// The variants as a table of Markdown.
std::string markdown_of(const WorkPrecision& study);
Json json_of(const WorkPrecision& study);

}  // namespace tactus::app
