#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include "engine/core/units.h"
#include "engine/guard/drive_limits.h"

namespace tactus::test {

inline constexpr Hertz kLoopRate = 48_kHz;

inline double logarithmic(std::mt19937& random, double low, double high) {
  return low * std::pow(high / low, std::uniform_real_distribution<double>{0, 1}(random));
}

/// A band pass with 0 dB at its centre (R. Bristow-Johnson, "Audio EQ cookbook").
struct Mode {
  double b, a1, a2;
  double x1 = 0, x2 = 0, y1 = 0, y2 = 0;

  static Mode of(double hz, double q) {
    const double w = 2 * kPi * hz / kLoopRate.value, alpha = std::sin(w) / (2 * q);
    return {alpha / (1 + alpha), -2 * std::cos(w) / (1 + alpha), (1 - alpha) / (1 + alpha)};
  }
  static Mode random(std::mt19937& random) {
    const double hz = logarithmic(random, 20, 2000);
    return of(hz, logarithmic(random, 0.7, 30));
  }
  double step(double x) {
    const double y = b * (x - x2) - a1 * y1 - a2 * y2;
    x2 = x1, x1 = x, y2 = y1, y1 = y;
    return y;
  }
  std::complex<double> at(std::complex<double> z) const {
    return b * (1.0 - z * z) / (1.0 + a1 * z + a2 * z * z);
  }
};

/// In frames.
struct LoopDelays {
  int least = 48, most = 1920;
};

/// What a loop does to an output: gain * sum of modes, behind a delay; without modes only the gain.
struct LoopShape {
  double gain = 1;
  int delay = 1;
  std::vector<Mode> modes = {};
  double noise = 1e-5;    ///< of the converter, or of the room
  bool internal = false;  ///< in the graph: it does not pass the guard

  static LoopShape random(std::mt19937& random, const LoopDelays& delays = {}) {
    LoopShape shape;
    shape.internal = random() % 5 == 0;
    shape.gain = (random() % 2 == 0 ? 1 : -1) * logarithmic(random, 1.02, 100);
    shape.delay = static_cast<int>(logarithmic(random, delays.least, delays.most));
    const auto modes = random() % 4;
    for (unsigned m = 0; m < modes; ++m) shape.modes.push_back(Mode::random(random));
    if (random() % 2 == 0) shape.noise = 0.02;
    return shape;
  }
  static LoopShape random_unstable(std::mt19937& random, const LoopDelays& delays = {}) {
    auto shape = LoopShape::random(random, delays);
    while (!shape.is_unstable()) shape = LoopShape::random(random, delays);
    return shape;
  }
  std::complex<double> open_loop(double hz) const {
    const auto z = std::polar(1.0, -2 * kPi * hz / kLoopRate.value);
    std::complex<double> sum = modes.empty() ? 1.0 : 0.0;
    for (const auto& mode : modes) sum += mode.at(z);
    return gain * sum * std::pow(z, delay);
  }
  /// Nyquist, with a margin of 3 %: 1 - L / 1.03 turns around 0 on the way from 0 Hz to half the rate.
  bool is_unstable() const {
    constexpr double kMargin = 1.03;
    if (modes.empty()) return std::abs(gain) > kMargin;
    double turned = 0;
    auto before = 1.0 - open_loop(0.01) / kMargin;
    for (double hz = 0.01; hz < kLoopRate.value / 2;) {
      hz = std::min(kLoopRate.value / 2, hz + std::clamp(hz * 0.002, 0.02, 0.5));
      const auto here = 1.0 - open_loop(hz) / kMargin;
      turned += std::arg(here / before);
      before = here;
    }
    return std::abs(turned) > 3.0;
  }
};

/// Such a loop, frame by frame, set off by a knock and its noise.
class Loop {
 public:
  Loop(const LoopShape& shape, unsigned seed)
      : shape_(shape), past_(static_cast<std::size_t>(shape.delay), 0.0), random_(seed) {}

  double next() {
    const double x = past_[at_];
    double y = shape_.modes.empty() ? x : 0;
    for (auto& mode : shape_.modes) y += mode.step(x);
    const double wanted = shape_.gain * y + shape_.noise * noise() + (frame_++ < 10 ? 1e-3 * noise() : 0.0);
    if (std::isfinite(wanted)) return wanted;
    *this = Loop{quiet(shape_), static_cast<unsigned>(random_())};  // as a player does
    return 0.0;
  }
  void took(double wanted, double out) {
    past_[at_] = shape_.internal ? wanted : out;
    at_ = (at_ + 1) % past_.size();
  }

 private:
  static LoopShape quiet(LoopShape shape) {
    for (auto& mode : shape.modes) mode.x1 = mode.x2 = mode.y1 = mode.y2 = 0;
    return shape;
  }
  double noise() { return std::uniform_real_distribution<double>{-1, 1}(random_); }

  LoopShape shape_;
  std::vector<double> past_;
  std::size_t at_ = 0;
  std::mt19937 random_;
  int frame_ = 0;
};

inline DriveLimits random_limits(std::mt19937& random) {
  DriveLimits limits{.ceiling = logarithmic(random, 0.2, 1.0)};
  if (random() % 2 == 0) limits.slew_per_second = logarithmic(random, 300, 50'000);
  if (random() % 3 == 0)
    limits.excursion = ExcursionLimits{.metres = 1.0,
                                       .metres_at_full_scale = logarithmic(random, 0.3, 3),
                                       .resonance = Hertz{logarithmic(random, 20, 200)},
                                       .q = logarithmic(random, 0.3, 15)};
  if (random() % 4 == 0) limits = conservative_limits();
  return limits;
}

/// A loud signal of a random kind, up to 40 dB above full scale; every third passes a stable loop through the
/// guard, whose gain is at most 0.7.
class LoudInstrument {
 public:
  static constexpr int kKinds = 16;

  explicit LoudInstrument(unsigned seed)
      : random_(seed),
        kind_(static_cast<int>(random_() % kKinds)),
        gain_(logarithmic(random_, 0.5, 100)),
        hz_(logarithmic(random_, 20, 4000)),
        rate_(logarithmic(random_, 0.5, 60)),
        depth_(std::uniform_real_distribution<double>{0.1, 1}(random_)),
        line_(static_cast<std::size_t>(std::max(8.0, 48'000 / hz_)), 0.0),
        echo_(static_cast<std::size_t>(logarithmic(random_, 480, 19'200)), 0.0) {
    if (random_() % 3 != 0) return;
    auto shape = LoopShape::random(random_);
    shape.internal = false;
    shape.noise = 0.0;
    double peak = 0;
    for (double hz = 5; hz < 20'000; hz *= 1.002) peak = std::max(peak, std::abs(shape.open_loop(hz)));
    shape.gain *= std::uniform_real_distribution<double>{0.1, 0.7}(random_) / peak;
    loop_.emplace_back(shape, seed);
  }
  int kind() const { return kind_; }
  double next() {
    step_envelopes();
    return gain_ * sample() + (loop_.empty() ? 0.0 : loop_.front().next());
  }
  void took(double wanted, double out) {
    if (!loop_.empty()) loop_.front().took(wanted, out);
  }

 private:
  double noise() { return std::uniform_real_distribution<double>{-1, 1}(random_); }
  double sine(double hz) {
    phase_ += hz / kLoopRate.value;
    phase_ -= std::floor(phase_);
    return std::sin(2 * kPi * phase_);
  }
  void step_envelopes() {
    time_ = frame_ / kLoopRate.value;
    slow_ += rate_ / kLoopRate.value;
    slow_ -= std::floor(slow_);
    event_ = frame_ >= next_event_;
    if (event_) {
      next_event_ = frame_ + static_cast<int>(kLoopRate.value * logarithmic(random_, 0.3, 3) / rate_);
      level_ = logarithmic(random_, 0.03, 1);
    }
    ++frame_;
  }
  double string() {
    if (event_)
      for (auto& s : line_) s += 0.5 * noise();
    auto& here = line_[at_];
    const double y = here;
    at_ = (at_ + 1) % line_.size();
    here = 0.498 * (here + line_[at_]);
    return y;
  }
  double echo() {
    envelope_ = event_ ? 1.0 : 0.999 * envelope_;
    auto& here = echo_[echo_at_];
    here = envelope_ * noise() + 0.9 * depth_ * here;
    const double y = here;
    echo_at_ = (echo_at_ + 1) % echo_.size();
    return y;
  }
  double note() {
    if (event_) hz_ = logarithmic(random_, 40, 3000), silent_ = random_() % 3 == 0;
    envelope_ += ((silent_ ? 0.0 : level_) - envelope_) * 0.002;
    return envelope_ * sine(hz_);
  }
  double strike(double decay_per_second) {
    if (event_) envelope_ = level_;
    return envelope_ *= std::exp(-decay_per_second / kLoopRate.value);
  }
  double pulse() {
    const double before = phase_;
    sine(std::min(hz_, 400.0));
    low_ += ((phase_ < before ? 1.0 : 0.05 * noise()) - low_) * 0.2;
    return 3 * low_;
  }
  double crescendo() {
    const double length = 0.3 + 3 * depth_, t = std::fmod(time_, length) / length;
    const double envelope = rate_ < 8 ? t : rate_ < 20 ? t * t : std::pow(10, 2 * (t - 1));
    return envelope * (hz_ < 400 ? sine(hz_) : noise());
  }
  double chord() const {
    double sum = 0;
    for (const double ratio : {1.0, 1.013, 1.5}) sum += std::sin(2 * kPi * hz_ * ratio * time_);
    return sum / 3;
  }
  double sample() {
    switch (kind_) {
      case 0:
        return sine(hz_);
      case 1:
        return sine(hz_) > 0 ? 1 : -1;
      case 2:
        return sine(hz_), 2 * phase_ - 1;
      case 3:
        return noise();
      case 4:
        return 3 * (low_ += (noise() - low_) * std::min(1.0, 2 * kPi * hz_ / kLoopRate.value));
      case 5:
        return string();
      case 6:
        return echo();
      case 7:
        return noise() * (1 - depth_ + depth_ * std::pow(0.5 + 0.5 * std::sin(2 * kPi * slow_), 4));
      case 8:
        return note();
      case 9:
        return chord();
      case 10:
        return sine(hz_) * (1 - depth_ + (slow_ < 0.5 ? depth_ : 0.0));
      case 11:
        return strike(3 * rate_) * noise();
      case 12:
        return pulse();
      case 13:
        return crescendo();
      case 14:
        return sine(hz_ * std::exp(depth_ * std::sin(2 * kPi * slow_)));
      default:
        return strike(8) * (sine(hz_) + 0.5 * std::sin(4 * kPi * phase_) + 0.1 * noise());
    }
  }

  std::mt19937 random_;
  int kind_;
  double gain_, hz_, rate_, depth_;
  std::vector<double> line_, echo_;
  std::vector<Loop> loop_;  ///< none or one
  std::size_t at_ = 0, echo_at_ = 0;
  double time_ = 0, phase_ = 0, slow_ = 0, envelope_ = 0, level_ = 1, low_ = 0;
  bool event_ = false, silent_ = false;
  int frame_ = 0, next_event_ = 0;
};

}  // namespace tactus::test
