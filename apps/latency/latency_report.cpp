#include "apps/latency/latency_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactus::app {

const char* const kDelayIs =
    "The delay runs from a voltage at the input to the answer at the output of a program that answers within "
    "the block: converters, driver, blocks and cable are in it.";

bool is_known(const Analysis& analysis) {
  return analysis.detected || analysis.finding.verdict != Verdict::Ok;
}

Hertz LatencyReport::sample_rate() const {
  const auto* opening = shown();
  if (opening == nullptr) return 48_kHz;
  return live ? opening->granted.format.sample_rate : opening->analysis.sample_rate;
}

const Opening* shown_of(const Measurement& measurement) {
  const auto& openings = measurement.openings;
  const auto found = std::find_if(openings.begin(), openings.end(), [&](const Opening& opening) {
    return opening.finding.verdict == measurement.finding.verdict;
  });
  if (found != openings.end()) return &*found;
  return openings.empty() ? nullptr : &openings.front();
}

std::string fixed(double value, int digits) {
  const bool zero = std::abs(value) < 0.5 * std::pow(10.0, -digits);
  return fmt::format("{:.{}f}", zero ? 0.0 : value, digits);
}

std::string with_error(double value, double standard_error) {
  const int digits =
      standard_error > 0 ? std::clamp(static_cast<int>(std::ceil(-std::log10(standard_error))), 0, 9) : 6;
  return fixed(value, digits) + " ± " + fixed(standard_error, digits);
}

}  // namespace tactus::app
