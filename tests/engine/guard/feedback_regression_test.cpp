#include "engine/guard/feedback_regression.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace tactus;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr int kPairs = 11;
using Regressions = FeedbackRegressions<kPairs>;
using Values = Regressions::Values;

/// Unit variance, correlated with its last value by `correlation`.
class Noise {
 public:
  explicit Noise(unsigned seed, double correlation) : random_(seed), correlation_(correlation) {}
  double next() {
    last_ = correlation_ * last_ + std::sqrt(1.0 - correlation_ * correlation_) * normal_(random_);
    return last_;
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  double correlation_, last_ = normal_(random_);
};

/// The standard deviation of t over many regressions in which r does not follow x.
double deviation_of_t(double correlation) {
  constexpr int kDraws = 400, kLength = 400;
  Noise x{1, correlation}, r{2, correlation};
  double squares = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Regressions regressions;
    for (int k = 0; k < kLength; ++k) {
      Values xs, rs, ones;
      for (std::size_t i = 0; i < kPairs; ++i) xs[i] = x.next(), rs[i] = r.next(), ones[i] = 1.0;
      regressions.add(xs, rs, ones, kPairs);
    }
    for (std::size_t i = 0; i < kPairs; ++i) squares += regressions.t(i) * regressions.t(i);
  }
  return std::sqrt(squares / (kDraws * kPairs));
}

}  // namespace

TEST_CASE("feedback regression: a response is found beside a mean and a trend, in each pair its own") {
  Noise noise{3, 0.5};
  Regressions regressions;
  std::array<int, kPairs> own{};  // values of each pair, of which some have none
  for (int k = 0; k < 60; ++k) {
    Values x, r, weight;
    for (std::size_t i = 0; i < kPairs; ++i) {
      weight[i] = (k + static_cast<int>(i)) % 4 == 0 ? 0.0 : 1.0;
      x[i] = noise.next();
      r[i] = 2.0 - 0.03 * own[i] + 0.2 * static_cast<double>(i) * x[i];
      own[i] += weight[i] > 0.0 ? 1 : 0;
    }
    regressions.add(x, r, weight, kPairs);
  }
  Regressions::Estimate estimate;
  regressions.estimate(kPairs, estimate);
  for (std::size_t i = 0; i < kPairs; ++i)
    CHECK_THAT(estimate.response[i], WithinAbs(0.2 * static_cast<double>(i), 1e-12));
}

TEST_CASE("feedback regression: the variance is that around the trend") {
  // x = k + (-1)^k over an even number n of values: the alternation has the variance 1, of which the trend
  // takes 3 / (n² - 1).
  constexpr int kLength = 100;
  Regressions regressions;
  for (int k = 0; k < kLength; ++k) {
    Values x, ones;
    x.fill(k + (k % 2 == 0 ? 1.0 : -1.0));
    ones.fill(1.0);
    regressions.add(x, x, ones, 1);
  }
  Regressions::Estimate estimate;
  regressions.estimate(1, estimate);
  CHECK_THAT(estimate.variance[0], WithinRel(1.0 - 3.0 / (kLength * kLength - 1.0), 1e-10));
}

TEST_CASE("feedback regression: t has the deviation 1 where nothing responds, also between slow signals") {
  // 4,400 draws know it to 1.1 %. The correlation of 400 values is itself known to some percent.
  CHECK_THAT(deviation_of_t(0.0), WithinAbs(1.0, 0.05));
  CHECK_THAT(deviation_of_t(0.8), WithinAbs(1.0, 0.08));
}
