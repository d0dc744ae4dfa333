#include "engine/scene/measures/notes/steady_tone.h"

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {
constexpr double kBegun = 0.178;  // -15 dB
}  // namespace

int partial_of(double hertz, double expected_hz) {
  const auto partial = static_cast<int>(std::lround(hertz / expected_hz));
  return partial >= 1 && std::abs(cents(hertz, partial * expected_hz)) <= kNearPartial_cents ? partial : 0;
}

std::vector<ToneMoment> moments_between(const std::vector<PitchPoint>& track, double from_s, double to_s,
                                        const std::function<double(double)>& expected) {
  std::vector<ToneMoment> moments;
  for (const auto& point : track)
    if (point.time_s >= from_s && point.time_s < to_s)
      moments.push_back({point.time_s, point.hertz, expected(point.time_s), point.rms});
  return moments;
}

std::optional<double> steady_from(const std::vector<ToneMoment>& moments, double off_cents, double rms,
                                  double hold_s) {
  const auto needed = static_cast<std::size_t>(std::max(1.0, std::round(hold_s / kPitchHop_s)));
  std::size_t run = 0;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const bool steady =
        std::abs(moments[i].off_cents() - off_cents) <= kNearPartial_cents && moments[i].rms >= kBegun * rms;
    const bool follows = i == 0 || moments[i].time_s - moments[i - 1].time_s < 1.5 * kPitchHop_s;
    run = !steady ? 0 : follows ? run + 1 : 1;
    if (run == needed) return moments[i + 1 - needed].time_s;
  }
  return std::nullopt;
}

double swing_of(std::vector<double> hertz) {
  if (hertz.empty()) return 0;
  std::sort(hertz.begin(), hertz.end());
  const auto edge = hertz.size() / 20;
  return cents(hertz[hertz.size() - 1 - edge], hertz[edge]);
}

}  // namespace tactus
