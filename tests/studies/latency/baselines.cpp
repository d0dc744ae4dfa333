#include "tests/studies/latency/baselines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "latency/estimation/fourier.h"

namespace tactus::study {
namespace {

using std::numbers::pi;
constexpr std::array kTones{4096, 512, 1088, 1544, 2049};
constexpr double kCircle = 65536.0;

double amplitude(std::size_t tone) { return tone == 0 ? 0.2 / 0.6 : 0.1 / 0.6; }

/// Phase lag of a tone, in turns.
double turns(std::span<const double> captured, std::size_t from, std::size_t to, int tone) {
  const double w = 2 * pi * tone / kCircle;
  std::complex<double> sum = 0.0;
  for (auto n = from; n < to; ++n) sum += captured[n] * std::polar(1.0, -w * static_cast<double>(n));
  return -(std::arg(sum) + pi / 2) / (2 * pi);  // the tones are sines
}

}  // namespace

double correlate_with_parabola(std::span<const double> played, std::span<const double> captured) {
  Fourier fourier{played.size() + captured.size()};
  const auto of_played = fourier.forward(played);
  auto cross = fourier.forward(captured);
  for (std::size_t b = 0; b < cross.size(); ++b) cross[b] *= std::conj(of_played[b]);
  const auto correlation = fourier.inverse(cross);
  const auto end = correlation.begin() + static_cast<std::ptrdiff_t>(captured.size());
  const auto top = std::max_element(correlation.begin(), end,
                                    [](double a, double b) { return std::abs(a) < std::abs(b); });
  const auto size = correlation.size();
  const auto place = static_cast<std::size_t>(top - correlation.begin());
  const double before = correlation[(place + size - 1) % size], after = correlation[(place + 1) % size];
  return static_cast<double>(place) + 0.5 * (before - after) / (before - 2.0 * *top + after);
}

std::vector<double> five_tones(std::size_t frames, double level) {
  std::vector<double> samples(frames, 0.0);
  for (std::size_t n = 0; n < frames; ++n)
    for (std::size_t k = 0; k < kTones.size(); ++k)
      samples[n] += level * amplitude(k) * std::sin(2 * pi * kTones[k] / kCircle * static_cast<double>(n));
  return samples;
}

double phase_delay_of_tones(std::span<const double> captured, std::size_t settled) {
  // Whole turns of every tone: a multiple of 65536 frames.
  const auto circles = (captured.size() - settled) / static_cast<std::size_t>(kCircle);
  const auto to = settled + circles * static_cast<std::size_t>(kCircle);
  const auto resolve = [&](double half_turn) {
    const double first = turns(captured, settled, to, kTones[0]) + half_turn;
    double delay = first - std::floor(first);  // in units of 16 frames
    double worst = 0.0, unit = 1.0;
    for (std::size_t k = 1; k < kTones.size(); ++k) {
      const double lag = turns(captured, settled, to, kTones[k]) + half_turn - delay * kTones[k] / kTones[0];
      const double eighths = 8.0 * (lag - std::floor(lag));
      const double whole = std::floor(eighths + 0.5);
      worst = std::max(worst, std::abs(eighths - whole));
      delay += unit * std::fmod(whole, 8.0);
      unit *= 8.0;
    }
    return std::pair{worst, 16.0 * delay};
  };
  return std::min(resolve(0.0), resolve(0.5)).second;  // upside down, each tone is half a turn off
}

}  // namespace tactus::study
