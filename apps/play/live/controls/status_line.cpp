#include "apps/play/live/controls/status_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/core/decibels.h"
#include "engine/core/index.h"

namespace tactus::app {
namespace {

const char* state_text(const SessionView& view) {
  if (view.state == StreamState::Lost) return "DEVICE LOST";
  if (view.state == StreamState::Stalled) return "NO BLOCKS COME";
  if (view.muted) return "muted";
  if (!view.drives) return "playing";
  return view.armed ? "armed" : "not armed";
}

/// How much room the parts of the line take.
struct Detail {
  int cells;         ///< of a bar
  std::size_t name;  ///< most bytes of a channel's name; 0: inputs and outputs have one bar each
  bool causes;       ///< of xruns, and the guard's stages
  bool load = true;
};

constexpr Detail kDetails[] = {{8, 99, true}, {8, 99, false}, {6, 99, false},      {4, 99, false},
                               {4, 6, false}, {4, 4, false},  {3, 3, false},       {2, 2, false},
                               {4, 0, false}, {1, 0, false},  {1, 0, false, false}};
constexpr double kLowest_db = -48.0;

/// Lengths count characters, not bytes.
std::string cut(const std::string& text, int columns) {
  int shown = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80 && ++shown > columns) return text.substr(0, i);
  return text;
}

int columns_of(const std::string& text) {
  return static_cast<int>(std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; }));
}

/// `share` of `cells` as '#', the others as '.'.
std::string cells_text(double share, int cells) {
  const int full = static_cast<int>(std::floor(std::clamp(share, 0.0, 1.0) * cells + 1e-9));
  return std::string(index(full), '#') + std::string(index(cells - full), '.');
}

std::string level_bar(double peak, int cells) {
  const double db = amplitude_to_db(peak);
  auto bar = cells_text(1.0 - db / kLowest_db, cells);
  if (peak >= 1.0) bar.back() = '!';
  return "[" + bar + "]";
}

std::string levels_text(const std::vector<SessionView::Level>& levels, const Detail& detail,
                        const char* together) {
  if (levels.empty()) return "";
  if (detail.name == 0)
    return together + std::string{" "} +
           level_bar(std::ranges::max(levels, {}, &SessionView::Level::peak).peak, detail.cells);
  std::vector<std::string> texts;
  for (const auto& level : levels)
    texts.push_back(cut(level.name, static_cast<int>(detail.name)) + " " +
                    level_bar(level.peak, detail.cells));
  return fmt::format("{}", fmt::join(texts, " "));
}

std::string percent_text(double share) { return fmt::format("{:.0f} %", 100 * share); }

std::string guard_text(const std::vector<std::string>& stages, const Detail& detail) {
  if (stages.empty()) return "";
  return detail.causes ? fmt::format("guard: {}", fmt::join(stages, ", ")) : "GUARD";
}

std::string line_of(const SessionView& view, const std::string& control, const Detail& detail) {
  const auto& health = view.health;
  std::vector<std::string> parts = {state_text(view)};
  const auto add = [&](std::string text) {
    if (!text.empty()) parts.push_back(std::move(text));
  };
  if (view.recorded_s) add(fmt::format("rec {:.0f} s", *view.recorded_s));
  add(guard_text(view.guard, detail));
  if (view.faults > 0) add(fmt::format("{} faults", view.faults));
  if (health.xruns > 0) add(detail.causes ? xrun_text(health) : fmt::format("{} xruns", health.xruns));
  const auto high = "load " + percent_text(health.high_load);
  if (detail.load)
    add(detail.cells > 4 ? fmt::format("{} (max {})", high, percent_text(health.peak_load)) : high);
  const auto inputs = levels_text(view.inputs, detail, "in"),
             outputs = levels_text(view.outputs, detail, "out");
  add(inputs + (inputs.empty() || outputs.empty() ? "" : " > ") + outputs);
  add(control);
  return fmt::format("{}", fmt::join(parts, " | "));
}

/// The first of the controls that are shown.
std::size_t first_shown(std::size_t count, std::size_t selected, std::size_t rows) {
  if (count <= rows) return 0;
  return std::min(selected > rows / 2 ? selected - rows / 2 : 0, count - rows);
}

}  // namespace

std::string level_text(double peak) {
  const double db = amplitude_to_db(peak);
  return db < -99 ? "silent" : fmt::format("{:.0f} dB", db);
}

std::string xrun_text(const Health& health) {
  if (health.xruns == 0) return "no xruns";
  std::vector<std::string> causes;
  for (std::size_t g = 0; g < kGaps; ++g)
    if (health.gaps[g] > 0)
      causes.push_back(fmt::format("{} {}", health.gaps[g], name_of(static_cast<Gap>(g))));
  return fmt::format("{} xrun{} ({}){}", health.xruns, health.xruns == 1 ? "" : "s", fmt::join(causes, ", "),
                     health.lost_frames > 0 ? fmt::format(", {} frames lost", health.lost_frames) : "");
}

std::string load_text(const Health& health) {
  return fmt::format("{:.2g} % of a block (p99.9 {:.2g} %, worst {:.2g} %)", 100 * health.median_load,
                     100 * health.high_load, 100 * health.peak_load);
}

std::string status_line(const SessionView& view, const std::string& control, int columns) {
  std::string line;
  for (const auto& detail : kDetails) {
    line = line_of(view, control, detail);
    if (columns_of(line) <= columns) return line;
  }
  return cut(line, columns);
}

std::string control_list(const LiveControls& controls, std::size_t selected, int columns, int rows) {
  constexpr int kCells = 12;
  const auto& all = controls.all();
  int widest_name = 0;
  for (const auto& live : all) widest_name = std::max(widest_name, columns_of(live.control.name));
  const auto padded = [](const std::string& text, int width) {
    return text + std::string(index(std::max(0, width - columns_of(text))), ' ');
  };
  const auto shown = std::min(all.size(), index(std::max(1, rows)));
  const auto first = first_shown(all.size(), selected, shown);
  std::vector<std::string> lines;
  for (auto c = first; c < first + shown; ++c) {
    const auto& control = all[c].control;
    const auto place = controls.can_change(c) ? "[" + cells_text(controls.position(c), kCells) + "]"
                                              : padded("constant", kCells + 2);
    lines.push_back(cut(fmt::format("{} {}  {}  {}", c == selected ? ">" : " ",
                                    padded(control.name, widest_name), place, controls.value_text(c)),
                        columns));
  }
  return fmt::format("{}", fmt::join(lines, "\n"));
}

}  // namespace tactus::app
