#include "latency/path/response.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <numeric>

#include "engine/core/decibels.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr std::int64_t kAtPath = 16;  // frames
constexpr double kOwn = 1e-9;         // -90 dB: what the probe's own edges leave where harmonics stand
constexpr double kPlayed = 1e-5;      // of the power of the loudest bin: below, nothing was played there
constexpr std::array kOctaves{31.25,  62.5,   125.0,  250.0,   500.0,   1000.0,
                              2000.0, 4000.0, 8000.0, 16000.0, 32000.0, 64000.0};

double loudest(const Spectrum& spectrum) {
  double highest = 0.0;
  for (const auto& bin : spectrum) highest = std::max(highest, std::norm(bin));
  return highest;
}

/// captured / played where something was played, faded out towards the ends of that band.
Spectrum divided(const CapturedWindow& window, const Spectrum& captured) {
  const double least = kPlayed * loudest(window.played);
  std::size_t low = window.played.size(), high = 0;
  for (std::size_t b = 1; b < window.played.size(); ++b) {
    if (std::norm(window.played[b]) < least) continue;
    low = std::min(low, b);
    high = b;
  }
  Spectrum ratio(captured.size());
  for (auto b = low; b <= high; ++b) {
    const double to_low = static_cast<double>(b - low) / static_cast<double>(low + 1);
    const double to_high = static_cast<double>(high - b) / (0.2 * static_cast<double>(high));
    const double fade = (0.5 - 0.5 * std::cos(pi * std::min(1.0, to_low))) *
                        (0.5 - 0.5 * std::cos(pi * std::min(1.0, to_high)));
    ratio[b] =
        fade * captured[b] * std::conj(window.played[b]) / std::max(std::norm(window.played[b]), least);
  }
  return ratio;
}

/// One octave: bins from low to high, each with its frequency, answer (without the delay), and weight.
struct Band {
  std::vector<double> w, weight;
  std::vector<Complex> answer;

  /// How well the answers agree when `delay` more is taken off, and their mean.
  Complex sum(double delay) const {
    Complex all = 0.0;
    for (std::size_t b = 0; b < w.size(); ++b) all += weight[b] * answer[b] * std::polar(1.0, w[b] * delay);
    return all;
  }
  double mean_w() const {
    double sum = 0.0, weights = 0.0;
    for (std::size_t b = 0; b < w.size(); ++b) {
      sum += weight[b] * w[b];
      weights += weight[b];
    }
    return sum / weights;
  }
};

/// Least squares of the phases around the mean phase: the slope that is left, and 1 / its variance.
std::pair<double, double> phase_slope(const Band& band, double delay) {
  const auto mean = band.sum(delay);
  const double centre = band.mean_w();
  double common = 0.0, weights = 0.0;
  for (std::size_t b = 0; b < band.w.size(); ++b) {
    const double off = band.w[b] - centre;
    const double strength = band.weight[b] * std::norm(band.answer[b]);
    common +=
        strength * off * std::arg(band.answer[b] * std::polar(1.0, band.w[b] * delay) * std::conj(mean));
    weights += strength * off * off;
  }
  return {-common / weights, 2.0 * weights};
}

/// Of the highest magnitude; the upper half of the circle is below 0.
double highest_place(const std::vector<double>& samples) {
  const auto highest = std::max_element(samples.begin(), samples.end(),
                                        [](double a, double b) { return std::abs(a) < std::abs(b); });
  const auto size = static_cast<double>(samples.size());
  return std::remainder(static_cast<double>(highest - samples.begin()), size);
}

std::size_t highest_power(const std::vector<double>& power) {
  return static_cast<std::size_t>(std::max_element(power.begin(), power.end()) - power.begin());
}

}  // namespace

std::vector<double> Response::deconvolved(const Spectrum& captured) const {
  return fourier_.inverse(divided(window_, captured));
}

std::vector<ResponsePoint> Response::spectrum() const {
  const double least = kPlayed * loudest(window_.played);
  std::vector<ResponsePoint> points;
  for (double f = 20.0; f < 0.5 * sample_rate_.value; f *= std::exp2(1.0 / 12)) {
    const double bins = f / sample_rate_.value * static_cast<double>(window_.size);
    const auto low = static_cast<std::size_t>(std::ceil(bins * std::exp2(-1.0 / 24)));
    const auto high = std::max(low, static_cast<std::size_t>(bins * std::exp2(1.0 / 24)));
    double power = 0.0, noise = 0.0;
    int count = 0;
    for (auto b = low; b <= high && b + 1 < window_.played.size(); ++b) {
      const double played_power = std::norm(window_.played[b]);
      if (!(played_power > least)) continue;
      power += std::norm(window_.captured[b] / window_.played[b]);
      noise += window_.noise[b] / played_power;
      ++count;
    }
    if (count == 0) continue;
    points.push_back({f, power_to_db(power / count), power_to_db(noise / count)});
  }
  return points;
}

std::vector<BandDelay> Response::group_delay(double at) const {
  const double least = kPlayed * loudest(window_.played);
  std::vector<BandDelay> delays;
  for (const double octave : kOctaves) {
    Band band;
    Spectrum alone(window_.played.size());
    double noise = 0.0, power = 0.0;
    for (std::size_t b = 1; b + 1 < window_.played.size(); ++b) {
      const double f = hertz(b);
      const double played_power = std::norm(window_.played[b]);
      if (f < octave / std::numbers::sqrt2 || f >= octave * std::numbers::sqrt2 || !(played_power > least))
        continue;
      const double w = angular_frequency(b, window_.size);
      band.w.push_back(w);
      band.answer.push_back(window_.captured[b] / window_.played[b] *
                            std::polar(1.0, w * model_.delay_frames));
      band.weight.push_back(played_power / window_.noise[b]);
      alone[b] = band.weight.back() * band.answer.back();
      noise += window_.noise[b];
      power += std::norm(window_.captured[b]);
    }
    if (band.w.size() < 8 || power < 4.0 * noise) continue;
    double delay = highest_place(fourier_.inverse(alone)), certainty = 0.0;
    for (int round = 0; round < 3; ++round) {
      const auto [more, weight] = phase_slope(band, delay);
      delay += more;
      certainty = weight;
    }
    delays.push_back({octave, at + model_.delay_frames + delay, 1.0 / std::sqrt(certainty)});
  }
  return delays;
}

std::vector<double> Response::impulse(int& first) const {
  const auto answer = deconvolved(window_.captured);
  const auto size = static_cast<int>(answer.size());
  const auto centre = static_cast<int>(std::lround(model_.delay_frames));
  const auto before = static_cast<int>(0.005 * sample_rate_.value),
             after = static_cast<int>(0.025 * sample_rate_.value);
  first = centre - before;
  std::vector<double> impulse;
  for (int n = first; n < centre + after; ++n) impulse.push_back(answer[index((n + size) % size)]);
  return impulse;
}

Response::Echo Response::echo() const {
  const auto path = model_.spectrum(window_.size, window_.profile);
  Spectrum direct(path.size()), rest(path.size());
  for (auto b = window_.lowest_bin; b < path.size(); ++b) {
    direct[b] = path[b] * window_.played[b];
    rest[b] = window_.captured[b] - direct[b];
  }
  const auto power_of = [&](const Spectrum& spectrum) {
    auto answer = deconvolved(spectrum);
    for (auto& value : answer) value *= value;
    return answer;
  };
  const auto main = power_of(direct);
  auto left = power_of(rest);
  const double all = std::accumulate(left.begin(), left.end(), 0.0);
  const auto size = static_cast<std::int64_t>(left.size());
  // The values at the path itself are its shape.
  const auto at = static_cast<std::int64_t>(highest_power(main));
  for (auto n = at - kAtPath; n <= at + kAtPath; ++n) left[index((n + size) % size)] = 0.0;
  Echo echo;
  for (int k = 0; k < 3; ++k) {
    const auto place = static_cast<std::int64_t>(highest_power(left));
    if (k == 0) {
      const auto from_main = place - at;
      echo.frames =
          static_cast<int>(std::remainder(static_cast<double>(from_main), static_cast<double>(size)));
      echo.level_db = power_to_db(left[index(place)] / *std::max_element(main.begin(), main.end()));
    }
    for (auto n = place - 8; n <= place + 8; ++n) {
      auto& value = left[index((n + size) % size)];
      echo.share += value / all;
      value = 0.0;
    }
  }
  return echo;
}

std::array<std::optional<double>, 4> Response::harmonics(const ExponentialSweep& probe,
                                                         const Spectrum& differences) const {
  constexpr double kHalf = 0.004;          // seconds around each response
  constexpr double kNowhere = 12.5;        // not a whole order: only noise is there
  constexpr double kFundamental = 1000.0;  // Hz
  const auto answer = deconvolved(window_.captured);
  const auto noise_only =
      differences.empty() ? std::vector<double>(answer.size(), 0.0) : deconvolved(differences);
  const auto size = static_cast<std::int64_t>(answer.size());
  const auto half = static_cast<std::int64_t>(kHalf * sample_rate_.value);
  const double growth = frames_in(probe.growth(), sample_rate_);
  // Mean power of the response at the position of order `place`, at the frequencies of another one.
  const auto power = [&](const std::vector<double>& of, double place, double order) {
    const auto centre = std::llround(model_.delay_frames - growth * std::log(place));
    std::vector<double> window;
    for (auto n = centre - half; n < centre + half; ++n) {
      const double fade =
          0.5 + 0.5 * std::cos(pi * static_cast<double>(n - centre) / static_cast<double>(half));
      window.push_back(std::sqrt(fade) * of[index((n % size + size) % size)]);
    }
    const auto spectrum = fourier_.forward(window);
    const double bins_per_hertz = static_cast<double>(fourier_.size()) / sample_rate_.value;
    const auto low = static_cast<std::size_t>(order * kFundamental / std::numbers::sqrt2 * bins_per_hertz);
    const auto high =
        std::min(spectrum.size() - 1,
                 static_cast<std::size_t>(order * kFundamental * std::numbers::sqrt2 * bins_per_hertz));
    double sum = 0.0;
    for (auto b = low; b < high; ++b) sum += std::norm(spectrum[b]);
    return high > low ? sum / static_cast<double>(high - low) : 0.0;
  };
  const double fundamental = power(answer, 1.0, 1.0);
  std::array<std::optional<double>, 4> found;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double order = static_cast<double>(k) + 2.0;
    const double harmonic = power(answer, order, order);
    const double noise = std::max(power(answer, kNowhere, order), power(noise_only, order, order));
    if (harmonic > 4.0 * noise && harmonic > kOwn * fundamental)
      found[k] = power_to_db((harmonic - noise) / fundamental);
  }
  return found;
}

}  // namespace tactus
