#pragma once

#include <string>
#include <vector>

#include "engine/plot/svg_layout.h"
#include "engine/plot/svg_scale.h"

namespace tactus::svg {

inline constexpr double kTitleFont = 17.0, kSubtitleFont = 12.5;  // [px]
inline constexpr double kTitleRow = 22.0, kSubtitleRow = 17.0, kLabelRow = 14.0;
inline constexpr double kPad = 16.0;  // around everything

/// A label over a panel: of an event or a span.
struct Band {
  std::vector<std::string> texts;
  std::vector<PlotColor> colors;
  std::vector<RowLabel> labels;

  int rows() const;
};

/// Where a panel lies.
struct PanelPlan {
  Scale x, y;
  PrefixedUnit unit;
  std::vector<Tick> ticks;
  Band band;
  double title_y, top, bottom;
};

/// Where everything lies [px].
struct Plan {
  std::vector<std::string> title, subtitle;
  std::vector<PanelPlan> panels;
  std::vector<Tick> x_ticks;
  PrefixedUnit x_unit;
  double left = 0, right = 0;  ///< of the plots
  double height = 0;
};
Plan plan_of(const Figure& figure);

}  // namespace tactus::svg
