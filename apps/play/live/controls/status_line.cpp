#include "apps/play/live/controls/status_line.h"

#include <fmt/format.h>

#include <vector>

#include "engine/core/decibels.h"

namespace tactus::app {
namespace {

const char* state_text(const SessionView& view) {
  if (view.state == StreamState::Lost) return "DEVICE LOST";
  if (view.state == StreamState::Stalled) return "NO BLOCKS COME";
  if (view.muted) return "muted";
  if (!view.drives) return "playing";
  return view.armed ? "armed" : "not armed";
}

std::string levels_text(const std::vector<SessionView::Level>& levels) {
  std::vector<std::string> texts;
  for (const auto& level : levels) texts.push_back(level.name + " " + level_text(level.peak));
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// Lengths count characters, not bytes.
std::string cut(const std::string& text, int columns) {
  int shown = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80 && ++shown > columns) return text.substr(0, i);
  return text;
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
  std::string first =
      fmt::format("{} | load {:.2g}, {:.2g}, {:.2g} % | {}", state_text(view), 100 * view.health.median_load,
                  100 * view.health.high_load, 100 * view.health.peak_load, xrun_text(view.health));
  if (!view.guard.empty()) first += fmt::format(" | guard: {}", fmt::join(view.guard, ", "));
  if (view.faults > 0) first += fmt::format(" | {} faults", view.faults);
  auto second = levels_text(view.inputs) + (view.inputs.empty() ? "" : " > ") + levels_text(view.outputs);
  if (!control.empty()) second += " | " + control;
  if (view.recorded_s) second += fmt::format(" | recorded {:.0f} s", *view.recorded_s);
  return cut(first, columns) + "\n" + cut(second, columns);
}

}  // namespace tactus::app
