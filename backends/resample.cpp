#include "backends/resample.h"

#include <cmath>
#include <numbers>

namespace tactus {
namespace {

constexpr int kZeros = 48;       // zero crossings of the sinc on each side
constexpr double kBeta = 10.06;  // Kaiser window: side lobes at -100 dB
constexpr double kRolloff = 0.95;
constexpr int kTableSteps = 1024;  // per zero crossing, interpolated linearly

double bessel_i0(double x) {
  double sum = 1;
  double term = 1;
  for (int k = 1; term > 1e-17 * sum; ++k) {
    term *= (x / (2 * k)) * (x / (2 * k));
    sum += term;
  }
  return sum;
}

/// sinc(kRolloff u) · Kaiser(u / kZeros) for u = 0 … kZeros zero crossings.
std::vector<double> kernel() {
  std::vector<double> table;
  for (int i = 0; i <= kZeros * kTableSteps + 1; ++i) {
    const double u = static_cast<double>(i) / kTableSteps;
    const double x = std::numbers::pi * kRolloff * u;
    const double inside = 1 - (u / kZeros) * (u / kZeros);
    const double window = inside > 0 ? bessel_i0(kBeta * std::sqrt(inside)) / bessel_i0(kBeta) : 0;
    table.push_back(kRolloff * (i == 0 ? 1 : std::sin(x) / x) * window);
  }
  return table;
}

double at(const std::vector<double>& table, double u) {
  const double position = u * kTableSteps;
  const auto i = static_cast<std::size_t>(position);
  if (i + 1 >= table.size()) return 0;
  return table[i] + (table[i + 1] - table[i]) * (position - static_cast<double>(i));
}

}  // namespace

Samples resample(const Samples& samples, Hertz to) {
  if (to == samples.sample_rate) return samples;
  static const auto table = kernel();
  const double step = samples.sample_rate / to;    // input frames an output frame
  const double scale = std::min(1.0, 1.0 / step);  // the kernel widens when the rate falls
  const auto reach = static_cast<std::int64_t>(std::ceil(kZeros / scale));
  const auto frames = samples.frames();
  const auto wanted = static_cast<std::int64_t>(std::llround(static_cast<double>(frames) / step));
  Samples result;
  result.sample_rate = to;
  for (const auto& channel : samples.channels) {
    std::vector<double> out(static_cast<std::size_t>(wanted));
    for (std::int64_t n = 0; n < wanted; ++n) {
      const double centre = static_cast<double>(n) * step;
      const auto middle = static_cast<std::int64_t>(centre);
      double sum = 0;
      for (std::int64_t k = std::max<std::int64_t>(0, middle - reach);
           k <= std::min(frames - 1, middle + reach); ++k)
        sum += channel[static_cast<std::size_t>(k)] *
               at(table, std::abs(static_cast<double>(k) - centre) * scale);
      out[static_cast<std::size_t>(n)] = sum * scale;
    }
    result.channels.push_back(std::move(out));
  }
  return result;
}

}  // namespace tactus
