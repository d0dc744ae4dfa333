#include "latency/estimation/fourier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/FFT>

#include "latency/estimation/loop_recording.h"

namespace tactus {
namespace {

/// The smallest of 2^k, 3 2^k, 5 2^k and 9 2^k that is long enough.
std::size_t quick_size(std::size_t at_least) {
  auto best = std::numeric_limits<std::size_t>::max();
  for (const std::size_t odd : {1u, 3u, 5u, 9u})
    best = std::min(best, odd * std::max<std::size_t>(4, std::bit_ceil((at_least + odd - 1) / odd)));
  return best;
}

constexpr int kToeplitzRounds = 400;
constexpr double kToeplitzSettled = 1e-9;  // of the right side

using Vector = std::vector<double>;

/// The spectrum of the circle of r, whose products are those of r's Toeplitz matrix; under a triangle it is
/// nearly the same and never negative.
Spectrum circle(Fourier& fourier, std::span<const double> r, std::size_t length, bool under_triangle) {
  const auto size = fourier.size();
  Vector circle(size, 0.0);
  circle[0] = r[0];
  for (std::size_t k = 1; k < length; ++k) {
    const double weight = under_triangle ? 1.0 - static_cast<double>(k) / static_cast<double>(length) : 1.0;
    circle[k] = circle[size - k] = weight * r[k];
  }
  return fourier.forward(circle);
}

}  // namespace

std::vector<double> smoothed_power(const Spectrum& spectrum) {
  // Sums of their own, and not differences of running ones: from bass to treble there may be 300 dB.
  const double twelfth = std::exp2(1.0 / 12), step = std::exp2(1.0 / 24);
  const auto mean_around = [&](double bin) {
    const auto low = static_cast<std::size_t>(bin / twelfth);
    const auto high =
        std::max(low + 1, std::min(spectrum.size(), static_cast<std::size_t>(bin * twelfth) + 1));
    double sum = 0.0;
    for (auto b = low; b < high; ++b) sum += std::norm(spectrum[b]);
    return sum / static_cast<double>(high - low);
  };
  std::vector<double> power(spectrum.size(), std::norm(spectrum[0]));
  const auto last = static_cast<double>(spectrum.size() - 1);
  double here = 1.0, at_here = mean_around(here);
  for (std::size_t b = 1; b < power.size();) {
    const double next = std::min(here * step, last), at_next = mean_around(next);
    for (; b < power.size() && static_cast<double>(b) <= next; ++b)
      power[b] = next > here ? std::lerp(at_here, at_next, (static_cast<double>(b) - here) / (next - here))
                             : at_here;
    here = next;
    at_here = at_next;
  }
  return power;
}

struct Fourier::Transform {
  Eigen::FFT<double> fft;
};

Fourier::Fourier(std::size_t at_least)
    : size_(quick_size(at_least)), transform_(std::make_unique<Transform>()), padded_(size_) {
  transform_->fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
}
Fourier::~Fourier() = default;

Spectrum Fourier::forward(std::span<const double> signal) {
  const auto length = std::min(signal.size(), size_);
  std::copy_n(signal.begin(), length, padded_.begin());
  std::fill(padded_.begin() + static_cast<std::ptrdiff_t>(length), padded_.end(), 0.0);
  Spectrum spectrum(bins());
  transform_->fft.fwd(spectrum.data(), padded_.data(), static_cast<Eigen::Index>(size_));
  return spectrum;
}

std::vector<double> Fourier::inverse(const Spectrum& spectrum) {
  std::vector<double> signal(size_);
  transform_->fft.inv(signal.data(), spectrum.data(), static_cast<Eigen::Index>(size_));
  return signal;
}

std::vector<double> solve_toeplitz(std::span<const double> r, std::span<const double> c) {
  Fourier fourier{2 * c.size()};
  const auto matrix = circle(fourier, r, c.size(), false), nearly = circle(fourier, r, c.size(), true);
  const auto product_with = [&](const Vector& x, bool inverse) {
    auto spectrum = fourier.forward(x);
    for (std::size_t b = 0; b < spectrum.size(); ++b)
      spectrum[b] *= inverse ? 1.0 / std::max(nearly[b].real(), 1e-300) : matrix[b].real();
    auto y = fourier.inverse(spectrum);
    y.resize(x.size());
    return y;
  };
  Vector h(c.size(), 0.0), rest(c.begin(), c.end());
  auto z = product_with(rest, true);
  auto direction = z;
  double strength = product(rest, z);
  const double settled = kToeplitzSettled * std::sqrt(product(rest, rest));
  for (int round = 0; round < kToeplitzRounds && std::sqrt(product(rest, rest)) > settled; ++round) {
    const auto turned = product_with(direction, false);
    const double step = strength / product(direction, turned);
    for (std::size_t n = 0; n < h.size(); ++n) {
      h[n] += step * direction[n];
      rest[n] -= step * turned[n];
    }
    z = product_with(rest, true);
    const double next = product(rest, z);
    for (std::size_t n = 0; n < h.size(); ++n) direction[n] = z[n] + next / strength * direction[n];
    strength = next;
  }
  return h;
}

}  // namespace tactus
