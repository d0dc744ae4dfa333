#include "engine/guard/excursion_limiter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "engine/core/units.h"
#include "engine/guard/drive_guard.h"

using namespace tactus;

namespace {

constexpr Hertz kRate = 48_kHz;

/// The moving mass of travel.h by Runge and Kutta's fourth-order method, four steps to a frame; in metres.
class FineMass {
 public:
  /// `turn`: where on the circle r = 1 it starts [rad]; without it, at rest.
  explicit FineMass(const ExcursionLimits& limits, std::optional<double> turn = {})
      : limits_(limits), w_(2 * kPi * limits.resonance.value) {
    if (turn) state_ = {limits.metres * std::cos(*turn), limits.metres * w_ * std::sin(*turn)};
  }
  /// Where and how fast it is, as a share of the limit: it never grows while y = 0.
  double r() const { return std::hypot(state_.x, state_.y / w_) / limits_.metres; }
  double frame(double y) {
    constexpr int kSteps = 4;
    const double h = 1.0 / kRate.value / kSteps;
    double farthest = 0.0;
    for (int n = 0; n < kSteps; ++n) {
      const auto k1 = slope(state_, y), k2 = slope(state_ + 0.5 * h * k1, y),
                 k3 = slope(state_ + 0.5 * h * k2, y), k4 = slope(state_ + h * k3, y);
      state_ = state_ + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      farthest = std::max(farthest, std::abs(state_.x));
    }
    return farthest;
  }

 private:
  Vector2 slope(Vector2 s, double y) const {
    return {s.y, w_ * w_ * (limits_.metres_at_full_scale * y - s.x) - w_ / limits_.q * s.y};
  }
  ExcursionLimits limits_;
  double w_;
  Vector2 state_;
};

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>{low, high}(random);
}
double logarithmic(std::mt19937& random, double low, double high) {
  return low * std::pow(high / low, uniform(random, 0, 1));
}

}  // namespace

TEST_CASE("travel: the mass never passes its limit, whatever is asked of it", "[core]") {
  std::mt19937 random{5};
  const bool starts_at_rest = GENERATE(true, false);
  double farthest = 0.0;
  for (int profile = 0; profile < 60; ++profile) {
    ExcursionLimits travel{.metres = logarithmic(random, 1e-4, 1e-2),
                           .metres_at_full_scale = 0,
                           .resonance = Hertz{logarithmic(random, 15, 400)},
                           .q = logarithmic(random, 0.2, 30)};
    travel.metres_at_full_scale = travel.metres * logarithmic(random, 0.1, 8);
    DriveLimits limits{.ceiling = uniform(random, 0.3, 1.0), .excursion = travel};
    if (profile % 2 == 1) limits.slew_per_second = logarithmic(random, 30, 50'000);
    DriveGuard guard{DriveGuard::Kind::Drive, limits, kRate};
    guard.set_open(true, 0);
    if (!starts_at_rest) guard.displace(1.0);
    FineMass mass{travel, starts_at_rest ? std::optional<double>{} : uniform(random, 0, 2 * kPi)};
    const double pitch = travel.resonance.value * logarithmic(random, 0.2, 3);
    for (int n = 0; n < 24'000; ++n) {
      // Resonance, steps at odd times, noise and held force: whatever drives it outwards.
      const int part = n / 4000 % 4;
      double y = part == 0   ? 1.4 * std::sin(2 * kPi * pitch * n / kRate.value)
                 : part == 1 ? (std::sin(2 * kPi * travel.resonance.value * n / kRate.value) > 0 ? 1.0 : -1.0)
                 : part == 2 ? uniform(random, -2, 2)
                             : 1.0;
      if (guard.take_feedback()) guard.set_open(true, n);
      guard.process(&y, 1, n);
      farthest = std::max(farthest, mass.frame(y) / travel.metres);
    }
  }
  INFO("farthest " << farthest << " of the limit");
  CHECK(farthest <= 1.0 + 1e-9);
  CHECK(farthest > 0.99);
}

// A server that does not wait for a client plays its last block again. What that throws the mass to is out of
// the guard's hands; behind it the drive comes to 0, and r can only fall. A guard that does not know of the
// gap drives on, and throws it farther.
TEST_CASE("travel: after a block that was played twice the mass is thrown no farther", "[core]") {
  const ExcursionLimits travel{.metres = 6e-3, .metres_at_full_scale = 18e-3, .resonance = 27_Hz, .q = 0.9};
  const int block = GENERATE(64, 256, 1024, 4096);
  double unnoticed = 0.0;
  for (int phase = 0; phase < 40; ++phase) {
    for (const bool noticed : {true, false}) {
      CAPTURE(block, phase);
      DriveGuard guard{DriveGuard::Kind::Drive, {.excursion = travel}, kRate, {false, false}};
      guard.set_open(true, 0);
      FineMass mass{travel};
      std::vector<double> y(static_cast<std::size_t>(block));
      int frame = 0;
      const auto play_block = [&] {
        double farthest = 0.0;
        for (auto& sample : y)
          sample = 50 * std::sin(2 * kPi * 27.0 * (frame++ + 44.0 * phase) / kRate.value);
        guard.process(y.data(), block, frame - block);
        for (const double sample : y) farthest = std::max(farthest, mass.frame(sample) / travel.metres);
        return farthest;
      };
      while (frame < 12'000) play_block();
      for (const double sample : y) mass.frame(sample);
      if (noticed) guard.displace(guard.displacement_after(block));
      const double allowed = std::max(1.0, mass.r());
      double farthest = 0.0;
      for (const int until = frame + 12'000; frame < until;) farthest = std::max(farthest, play_block());
      if (noticed) CHECK(farthest <= allowed + 1e-9);
      if (!noticed) unnoticed = std::max(unnoticed, farthest / allowed);
    }
  }
  if (block == 256) CHECK(unnoticed > 1.05);
}

TEST_CASE("travel: where the start is unknown, the force comes as a free motion decays", "[core]") {
  // Free, r falls by exp(-w t / 2Q) on average, within a factor of sqrt((2Q + 1) / (2Q - 1)).
  const ExcursionLimits travel{.metres = 5e-3, .metres_at_full_scale = 4e-3, .resonance = 30_Hz, .q = 10};
  DriveGuard guard{DriveGuard::Kind::Drive, {.excursion = travel}, kRate};
  guard.displace(1.0);
  const double decay = kPi * 30.0 / 10.0, ripple = std::sqrt(21.0 / 19.0);
  std::vector<double> silence(64);
  for (int n = 0; n < 48'000; n += 64) {
    guard.process(silence.data(), 64, n);
    const double free = std::exp(-decay * (n + 64) / kRate.value);
    REQUIRE(guard.displacement() <= free * ripple + 1e-12);
    REQUIRE(guard.displacement() >= free / ripple);
  }
  for (int n = 48'000; n < 96'000; n += 64) guard.process(silence.data(), 64, n);
  CHECK(guard.displacement() == 0.0);  // below a millionth it is forgotten
}

TEST_CASE("travel: a force that holds the mass just within its limit passes, and a little more does not",
          "[core]") {
  const ExcursionLimits travel{.metres = 5e-3, .metres_at_full_scale = 10e-3, .resonance = 30_Hz, .q = 0.4};
  const auto held_back = [&](double y, double slew_per_second, int rise) {
    DriveGuard guard{
        DriveGuard::Kind::Drive, {.slew_per_second = slew_per_second, .excursion = travel}, kRate};
    guard.set_open(true, 0);
    std::vector<double> samples(96'000, y);
    for (int n = 0; n < rise; ++n) samples[static_cast<std::size_t>(n)] = y * n / rise;
    guard.process(samples.data(), 96'000, 0);
    return guard.counts()[GuardStage::Excursion].frames;
  };
  constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  CHECK(held_back(0.4995, kNoLimit, 0) == 0);  // all at once: at this Q nothing swings over
  CHECK(held_back(0.501, kNoLimit, 0) > 0);
  CHECK(held_back(0.49, 100.0, 48'000) ==
        0);  // there is a way back through the slew limit, if it goes slowly
  CHECK(held_back(0.501, 100.0, 48'000) > 0);
}

TEST_CASE("travel: what it lets through is what reaches the limit, not less", "[core]") {
  // Far below resonance the mass follows the force: at twice the limit it must come to stand at the limit.
  const ExcursionLimits travel{.metres = 5e-3, .metres_at_full_scale = 10e-3, .resonance = 30_Hz, .q = 0.7};
  DriveGuard guard{DriveGuard::Kind::Drive, {.excursion = travel}, kRate, FeedbackPath{false, false}};
  guard.set_open(true, 0);
  std::vector<double> samples(4800, 1.0);
  guard.process(samples.data(), 4800, 0);
  CHECK(samples.back() == Approx(0.5).epsilon(1e-3));
}
