#include "tests/studies/onset/clean_hit.h"

#include <algorithm>
#include <cmath>

namespace tactus::study {
namespace {

float peak(const std::vector<float>& hit, std::size_t from, std::size_t to) {
  float highest = 0;
  for (std::size_t n = from; n < std::min(to, hit.size()); ++n) highest = std::max(highest, std::abs(hit[n]));
  return highest;
}

std::size_t first_above(const std::vector<float>& hit, std::size_t from, float level) {
  std::size_t n = from;
  while (n < hit.size() && std::abs(hit[n]) < level) ++n;
  return n;
}

bool rises_again(const std::vector<float>& hit, double sample_rate, float highest) {
  const auto window = static_cast<std::size_t>(0.010 * sample_rate);
  for (std::size_t n = 2 * window; n + window <= hit.size(); n += window / 2) {
    const float now = peak(hit, n, n + window);
    if (now > 0.1f * highest && now > 2 * peak(hit, n - window, n)) return true;
  }
  return false;
}

}  // namespace

std::vector<float> trimmed(const std::vector<float>& recording) {
  const std::size_t start = first_above(recording, 0, 0.01f * peak(recording, 0, recording.size()));
  return {recording.begin() + static_cast<std::ptrdiff_t>(start), recording.end()};
}

CleanHit measure(const std::vector<float>& hit, double sample_rate) {
  const float early = peak(hit, 0, static_cast<std::size_t>(0.010 * sample_rate));
  const float highest = peak(hit, 0, hit.size());
  const std::size_t onset = first_above(hit, 0, 0.1f * early);
  const std::size_t top = first_above(hit, onset, 0.9f * early);
  CleanHit result;
  result.onset = static_cast<double>(onset) / sample_rate;
  result.rise = static_cast<double>(top - onset) / sample_rate;
  result.peak_time = static_cast<double>(first_above(hit, 0, highest)) / sample_rate;
  result.several_strokes = result.peak_time > 0.020 || rises_again(hit, sample_rate, highest);
  return result;
}

double fall_db(const std::vector<float>& hit, double sample_rate, double seconds) {
  std::vector<float> difference(std::min(hit.size(), static_cast<std::size_t>(seconds * sample_rate)));
  for (std::size_t n = 1; n < difference.size(); ++n) difference[n] = hit[n] - hit[n - 1];
  const auto frame = [&](double time) { return static_cast<std::size_t>(time * sample_rate); };
  const auto fall = [&](const std::vector<float>& signal) {
    const double then = static_cast<double>(peak(signal, frame(seconds - 0.010), frame(seconds)));
    return 20 * std::log10(static_cast<double>(peak(signal, 0, frame(0.005))) / std::max(then, 1e-6));
  };
  return std::max(fall(hit), fall(difference));
}

}  // namespace tactus::study
