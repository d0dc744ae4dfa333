#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <random>

#include "engine/scene/measures/playability_result.h"
#include "tests/support/reading.h"

using namespace tactus;
using tactus::test::reading;

namespace {

constexpr double kRate = 8000, kDuration_s = 5;

/// Times from `first` on, `intervals` over and over.
std::vector<double> strokes(double first, std::vector<double> intervals, double last = kDuration_s) {
  std::vector<double> times;
  double now = first;
  for (std::size_t i = 0; now < last; now += intervals[i++ % intervals.size()]) times.push_back(now);
  return times;
}

/// Strikes of 20 N and 1 ms; each hit is a trigger 0.5 ms later.
SceneRecording recorded(const std::vector<double>& strikes, const std::vector<double>& detected,
                        double every_other = 20) {
  const auto frames = static_cast<std::size_t>(kRate * kDuration_s);
  SceneRecording recording;
  recording.sample_rate = Hertz{kRate};
  recording.signals = {{"plant.contact", Dimension{}, std::vector<double>(frames, 0.0)},
                       {"instrument.hit.hit", Dimension{}, std::vector<double>(frames, 0.0)}};
  double force = every_other;
  for (const double time : strikes) {
    force = force == 20 ? every_other : 20;
    for (int i = 0; i < 8; ++i) {
      const auto frame = static_cast<std::size_t>(std::lround(time * kRate)) + static_cast<std::size_t>(i);
      if (frame < frames) recording.signals[0].samples[frame] = force;
    }
  }
  for (const double time : detected) {
    const auto frame = static_cast<std::size_t>(std::lround((time + 0.5e-3) * kRate));
    if (frame < frames) recording.signals[1].samples[frame] = 1;
  }
  return recording;
}

Playability asking_for(Playability::Roll roll, std::optional<double> rate_hz = {}) {
  Playability playability;
  playability.roll = roll;
  playability.rate_hz = rate_hz;
  return playability;
}

PlayabilityResult result_of(const std::vector<double>& strikes, const std::vector<double>& detected,
                            Playability playability = {}) {
  playability.hits.name = "instrument.hit";
  playability.contact.name = "plant.contact";
  return evaluate(recorded(strikes, detected), playability);
}

}  // namespace

TEST_CASE("roll: even intervals have no spread, a gallop repeats after two, three or four", "[analysis]") {
  CHECK(evenness_of(strokes(0, {0.05})).spread == Approx(0).margin(1e-9));
  CHECK(evenness_of(strokes(0, {0.05})).beats == 1);
  // Mean 40 ms, each 20 ms off it.
  const auto gallop = evenness_of(strokes(0, {0.02, 0.06}, 40));
  CHECK(gallop.spread == Approx(0.5).epsilon(0).margin(1e-3));
  CHECK(gallop.beats == 2);
  CHECK(gallop.pattern_spread == Approx(0).margin(1e-9));
  CHECK(evenness_of(strokes(0, {0.02, 0.03, 0.06})).beats == 3);
  CHECK(evenness_of(strokes(0, {0.02, 0.03, 0.06, 0.025})).beats == 4);
}

// For independent intervals the mean of (I[n+p] - I[n])^2 is twice their variance, whatever p.
TEST_CASE("roll: chance has the same spread for every pattern", "[analysis]") {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> interval{0.02, 0.06};
  std::vector<double> times{0};
  for (int i = 0; i < 20000; ++i) times.push_back(times.back() + interval(random));
  const auto even = evenness_of(times);
  const double theory = (0.04 / std::sqrt(12.0)) / 0.04;
  CHECK(even.spread == Approx(theory).epsilon(0.02));
  CHECK(even.pattern_spread == Approx(theory).epsilon(0.03));
}

TEST_CASE("roll: a roll that is even and all detected has the score 1", "[analysis]") {
  const auto times = strokes(0.1, {0.05});
  const auto run = result_of(times, times);
  CHECK(run.kind == "regular");
  CHECK(run.score == Approx(1));
  CHECK(run.playable);
  CHECK(reading(run, Playability::Kind::Roll, "rate_hz") == Approx(20).epsilon(1e-3));
  CHECK(reading(run, Playability::Kind::Roll, "long_short") == Approx(1).epsilon(0.01));
}

// Intervals of 20 and 60 ms: spread 0.5, ratio 3. In the gallop that is asked for nothing is missing but a
// larger ratio.
TEST_CASE("roll: long and short is good where a gallop is asked for, and not as an even roll", "[analysis]") {
  const auto times = strokes(0.1, {0.02, 0.06});
  const auto as = [&](Playability::Roll roll) { return result_of(times, times, asking_for(roll)); };
  const auto gallop = as(Playability::Roll::Gallop);
  CHECK(gallop.kind == "gallop");
  CHECK(gallop.score == Approx(1 - 1 / (1 + std::pow(std::log(3.0) / std::log(1.25), 2))).epsilon(0.01));
  CHECK(gallop.playable);
  CHECK(reading(gallop, Playability::Kind::Roll, "long_short") == Approx(3).epsilon(0.03));
  const auto even = as(Playability::Roll::Even);
  CHECK(even.score == Approx(1 / (1 + 2.5 * 2.5)).epsilon(0.02));
  CHECK_FALSE(even.playable);
  CHECK(as(Playability::Roll::Any).score == Approx(1));
  const auto steady = strokes(0.1, {0.05});
  CHECK(result_of(steady, steady, asking_for(Playability::Roll::Gallop)).score == Approx(0).margin(1e-3));
}

TEST_CASE("roll: six growing intervals are a roll backwards", "[analysis]") {
  const auto growing = [](int intervals) {
    std::vector<double> times{1.0};
    for (int i = 0; i <= intervals; ++i) times.push_back(times.back() + 0.03 * std::pow(1.25, i));
    for (int i = 0; i < 3; ++i) times.push_back(times.back() + 0.03);
    return times;
  };
  const auto run = [&](int intervals) {
    const auto times = growing(intervals);
    auto playability = asking_for(Playability::Roll::Backwards);
    playability.to_s = 2.0;
    playability.fewest = 5;
    return result_of(times, times, playability);
  };
  CHECK(run(6).kind == "backwards");
  CHECK(run(6).score == Approx(1));
  CHECK(run(3).score == Approx(0.25));
}

TEST_CASE("roll: the rate that is asked for, and strikes of one loudness, count", "[analysis]") {
  const auto times = strokes(0.1, {0.05});
  CHECK(result_of(times, times, asking_for(Playability::Roll::Even, 20)).score == Approx(1).epsilon(1e-3));
  CHECK(result_of(times, times, asking_for(Playability::Roll::Even, 23)).score == Approx(0.5).epsilon(1e-3));
  // Loud and soft in turn by 6 dB: the root mean square of the differences over sqrt(2) is 6 / sqrt(2).
  Playability playability;
  playability.hits.name = "instrument.hit";
  playability.contact.name = "plant.contact";
  const auto uneven = evaluate(recorded(times, times, 20 / std::pow(10, 0.3)), playability);
  CHECK(uneven.score == Approx(1 / 1.5).epsilon(1e-3));
}

TEST_CASE("roll: an irregular roll loses by its spread", "[analysis]") {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> interval{0.01, 0.09};
  std::vector<double> times{0.1};
  while (times.back() < kDuration_s) times.push_back(times.back() + interval(random));
  const auto run = result_of(times, times);
  const double spread = reading(run, Playability::Kind::Roll, "spread");
  CHECK(run.kind == "irregular");
  CHECK(spread > 0.3);
  CHECK(run.score == Approx(near(spread, kHalfSpread)).epsilon(1e-9));
  CHECK_FALSE(run.playable);
}

// Windows of 1 s begin at 1.0, 1.1 … 4.0 s: 31. With 20 strikes a second until 3 s, those that begin up to
// 2.5 s have ten: 16.
TEST_CASE("roll: a roll that ends is dead, and keeps the share that it lasted", "[analysis]") {
  const auto times = strokes(0.1001, {0.05}, 3.0);
  const auto run = result_of(times, times);
  CHECK(run.kind == "dead");
  CHECK(run.score == Approx(16.0 / 31).epsilon(1e-6));
  CHECK_FALSE(run.playable);
}

TEST_CASE("roll: what is missed or doubled takes its share", "[analysis]") {
  const auto times = strokes(0.1, {0.05});
  std::vector<double> some, more = times;
  for (std::size_t i = 0; i < times.size(); ++i)
    if (i % 4 != 3) some.push_back(times[i]);
  CHECK(result_of(times, some).score < 0.76);
  for (const double time : times) more.push_back(time + 0.025);
  std::sort(more.begin(), more.end());
  const auto doubled = result_of(times, more);
  CHECK(reading(doubled, Playability::Kind::Roll, "doubled") == Approx(80).margin(1));
  CHECK(doubled.score == Approx(0.5).epsilon(0.01));
}

TEST_CASE("roll: a drum that hears itself is dead", "[analysis]") {
  const auto run = result_of({}, strokes(0.1, {0.05}));
  CHECK(run.kind == "dead");
  CHECK(run.score == 0);
}
