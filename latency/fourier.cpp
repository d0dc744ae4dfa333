#include "latency/fourier.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <unsupported/Eigen/FFT>

namespace tactus {
namespace {

/// The smallest of 2^k, 3 2^k, 5 2^k and 9 2^k that is long enough.
std::size_t quick_size(std::size_t at_least) {
  auto best = std::numeric_limits<std::size_t>::max();
  for (const std::size_t odd : {1u, 3u, 5u, 9u})
    best = std::min(best, odd * std::max<std::size_t>(4, std::bit_ceil((at_least + odd - 1) / odd)));
  return best;
}

}  // namespace

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

}  // namespace tactus
