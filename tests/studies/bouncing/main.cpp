#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "engine/plot/plot.h"
#include "engine/study/orbits/bouncing_ball.h"

// The ball on a driven table, exactly: `bouncing_study PICTURE.svg` draws where it lands against how hard the
// table is driven, and prints where its period doubles.

using namespace tactus;

namespace {

constexpr double kDrawnRestitution = 0.5;

/// Phases of the landings when the ball has settled, on the branch that begins as one bounce a period.
PlotSeries landings() {
  PlotSeries series{.mark = PlotMark::Points, .color = PlotColor::Blue};
  auto bounce = BouncingBall(1.2, kDrawnRestitution).orbit(1);
  for (double drive = 1.2; drive < 1.75; drive += 0.0015) {
    const BouncingBall ball(drive, kDrawnRestitution);
    for (int i = 0; i < 600; ++i) bounce = ball.next(bounce);
    for (int i = 0; i < 48; ++i) {
      bounce = ball.next(bounce);
      series.x.push_back(drive);
      series.y.push_back(std::remainder(bounce.phase, 2 * std::numbers::pi));
    }
    bounce.phase = std::remainder(bounce.phase, 2 * std::numbers::pi);
  }
  return series;
}

void print_doublings() {
  fmt::print(
      "| restitution | 1 to 2 bounces, closed form | found | 2 to 4 | 4 to 8 | 8 to 16 | 16 to 32 | ratios "
      "|\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const double restitution : {0.2, 0.5, 0.85}) {
    fmt::print("| {} | {:.8f} |", restitution, BouncingBall::orbit_doubles(1, restitution));
    const auto found = period_doublings(1, restitution, 5);
    for (const double drive : found) fmt::print(" {:.8f} |", drive);
    for (std::size_t i = 2; i < found.size(); ++i)
      fmt::print("{} {:.3f}", i > 2 ? "," : "", (found[i - 1] - found[i - 2]) / (found[i] - found[i - 1]));
    fmt::print(" |\n");
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: bouncing_study PICTURE.svg\n"), 2;
  print_doublings();
  const Plot plot{
      .title = "A ball on a driven table: phase of its landings",
      .subtitle = fmt::format("restitution {}, exact map; 48 landings at each drive", kDrawnRestitution),
      .x = {.label = "largest acceleration of the table over that of gravity"},
      .subplots = {{.y = {.label = "phase of the table at the landing [rad]"}, .series = {landings()}}},
      .subplot_height = 420};
  const auto written = write_svg(arguments[1], {plot});
  return written ? 0 : (std::fprintf(stderr, "%s\n", to_string(written.error()).c_str()), 3);
}
