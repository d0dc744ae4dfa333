#include "engine/dsp/delays/resample.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "engine/core/matrix2.h"

namespace tactus {
namespace {

// A Kaiser window with side lobes at -100 dB needs (100 - 8) / (2.285 pi) / 128 = 0.1 of the Nyquist
// frequency for its way down: from 0.9 to 1.0 of it, with half of the way at the rolloff.
constexpr int kZeros = 64;  // zero crossings of the sinc on each side
constexpr double kBeta = 10.06;
constexpr double kRolloff = 0.95;
constexpr std::int64_t kMostPhases = 1000;  // 44.1 and 48 kHz meet in 160, 44.1 and 96 in 147
constexpr int kTableSteps = 1024;           // per zero crossing, interpolated linearly

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

/// Where an output frame lies among the input's, and the width of the kernel.
struct Grid {
  double step;   ///< input frames an output frame
  double scale;  ///< below 1 the kernel is wider: the rate falls
  std::int64_t reach;

  Grid(Hertz from, Hertz to)
      : step(from / to),
        scale(std::min(1.0, to / from)),
        reach(static_cast<std::int64_t>(std::ceil(kZeros / scale))) {}

  /// Weights of the input frames middle - reach … middle + reach for an output `fraction` behind the middle.
  void weigh(double fraction, double* weights) const {
    static const auto table = kernel();
    for (std::int64_t k = -reach; k <= reach; ++k)
      *weights++ = scale * at(table, std::abs(static_cast<double>(k) - fraction) * scale);
  }
  std::size_t taps() const { return static_cast<std::size_t>(2 * reach + 1); }
};

/// After how many output frames the fractions repeat; 0: never, or too late to be of use.
std::int64_t phases(Hertz from, Hertz to) {
  if (from.value != std::floor(from.value) || to.value != std::floor(to.value)) return 0;
  if (std::max(from.value, to.value) > 1e9) return 0;
  const auto out = static_cast<std::int64_t>(to.value);
  const auto count = out / std::gcd(out, static_cast<std::int64_t>(from.value));
  return count <= kMostPhases ? count : 0;
}

/// Weights for each output frame: of all phases beforehand if they are few, else anew.
class Weights {
 public:
  Weights(const Grid& grid, Hertz from, Hertz to)
      : grid_(grid), phases_(phases(from, to)), from_(from), to_(to) {
    const auto stored = std::max<std::int64_t>(1, phases_);
    weights_.resize(static_cast<std::size_t>(stored) * grid.taps());
    for (std::int64_t p = 0; p < phases_; ++p) grid_.weigh(position(p).second, row(p));
  }

  /// The input frame before output frame `n`, and how far behind it that lies.
  std::pair<std::int64_t, double> position(std::int64_t n) const {
    if (phases_ > 0) {  // exact: whole numbers
      const auto times = n * static_cast<std::int64_t>(from_.value);
      const auto rate = static_cast<std::int64_t>(to_.value);
      const auto behind = (times % rate + rate) % rate;
      return {(times - behind) / rate, static_cast<double>(behind) / to_.value};
    }
    const double centre = static_cast<double>(n) * grid_.step;
    return {static_cast<std::int64_t>(std::floor(centre)), centre - std::floor(centre)};
  }
  const double* of(std::int64_t n, double fraction) {
    if (phases_ > 0) return row((n % phases_ + phases_) % phases_);
    grid_.weigh(fraction, row(0));
    return row(0);
  }

 private:
  double* row(std::int64_t phase) { return weights_.data() + static_cast<std::size_t>(phase) * grid_.taps(); }

  const Grid& grid_;
  std::int64_t phases_;
  Hertz from_, to_;
  std::vector<double> weights_;
};

constexpr std::size_t kFolded = 32;  // taps that take up what lies before frame 0
constexpr double kBand = 0.5;        // of the lower Nyquist frequency, where they do so best
constexpr double kElsewhere = 1e-4;  // how much an error counts above it
constexpr double kDropped = 1e-8;    // of the sum of all |taps|: what may be left off at the end

/// Adds to the taps from 0 on what is nearest to `early`, the taps before 0 (the last is at -1):
///   minimum over d of  ∫ W(w) |sum over m >= 0 of d[m] e^(-iwm) - sum over n < 0 of early[n] e^(-iwn)|² dw
/// with W = 1 below `band` [rad/frame] and kElsewhere above it.
void fold(const std::vector<double>& early, double band, std::vector<double>& taps) {
  const auto correlation = [&](std::size_t lag) {
    if (lag == 0) return kElsewhere + (1 - kElsewhere) * band / std::numbers::pi;
    const auto frames = static_cast<double>(lag);
    return (1 - kElsewhere) * std::sin(band * frames) / (std::numbers::pi * frames);
  };
  const auto count = std::min(kFolded, taps.size());
  std::vector<double> matrix, right(count);
  for (std::size_t m = 0; m < count; ++m) {
    for (std::size_t k = 0; k < count; ++k) matrix.push_back(correlation(std::max(m, k) - std::min(m, k)));
    for (std::size_t n = 0; n < early.size(); ++n) right[m] += early[n] * correlation(m + early.size() - n);
  }
  solve_symmetric(matrix.data(), right.data(), count);
  for (std::size_t m = 0; m < count; ++m) taps[m] += right[m];
}

void drop_silent_end(std::vector<double>& taps) {
  double sum = 0, tail = 0;
  for (const double tap : taps) sum += std::abs(tap);
  for (; taps.size() > 1; taps.pop_back())
    if ((tail += std::abs(taps.back())) > kDropped * sum) break;
}

/// Frames at `to` that the resampling reaches before and behind.
std::size_t reach_at_rate(Hertz from, Hertz to) {
  return static_cast<std::size_t>(std::ceil(static_cast<double>(resampling_reach(from, to)) * (to / from)));
}

}  // namespace

double bessel_i0(double x) {
  double sum = 1;
  double term = 1;
  for (int k = 1; term > 1e-17 * sum; ++k) {
    term *= (x / (2 * k)) * (x / (2 * k));
    sum += term;
  }
  return sum;
}

std::vector<double> resample(std::span<const double> input, Hertz from, Hertz to, std::int64_t first,
                             std::int64_t count) {
  const Grid grid{from, to};
  Weights weights{grid, from, to};
  std::vector<double> output(static_cast<std::size_t>(count));
  for (std::int64_t n = 0; n < count; ++n) {
    const auto [middle, fraction] = weights.position(first + n);
    const double* const weight = weights.of(first + n, fraction);
    const auto begin = std::max<std::int64_t>(0, middle - grid.reach);
    const auto end = std::min(static_cast<std::int64_t>(input.size()), middle + grid.reach + 1);
    double sum = 0;
    for (auto k = begin; k < end; ++k)
      sum += input[static_cast<std::size_t>(k)] * weight[k - middle + grid.reach];
    output[static_cast<std::size_t>(n)] = sum;
  }
  return output;
}

std::int64_t resampling_reach(Hertz from, Hertz to) { return Grid{from, to}.reach; }

std::vector<double> taps_at_rate(std::span<const double> taps, Hertz from, Hertz to) {
  if (from == to) return {taps.begin(), taps.end()};
  const auto before = static_cast<std::int64_t>(reach_at_rate(from, to));
  const auto length = static_cast<std::int64_t>(length_at_rate(taps.size(), from, to));
  auto result = resample(taps, from, to, 0, length);
  fold(resample(taps, from, to, -before, before), kBand * std::numbers::pi * std::min(1.0, from / to),
       result);
  for (double& tap : result) tap *= from / to;
  drop_silent_end(result);
  return result;
}

std::size_t length_at_rate(std::size_t taps, Hertz from, Hertz to) {
  if (from == to) return taps;
  const double frames = std::ceil(static_cast<double>(taps) * (to / from));
  return static_cast<std::size_t>(frames) + reach_at_rate(from, to);
}

}  // namespace tactus
