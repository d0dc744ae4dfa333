#include "latency/path/level.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

using namespace tactus;

namespace {

using Step = LevelSearch::Step;

/// A path with a gain and a delay of whole windows, in noise of a steady power.
struct Path {
  double gain = 1.0;
  int delay = 1;
  double noise_power = 1e-9;

  LevelWindow captured(const std::vector<double>& played, int window) const {
    const int at = window - delay;
    const double level =
        at >= 0 && at < static_cast<int>(played.size()) ? played[static_cast<std::size_t>(at)] : 0.0;
    const double peak = std::min(1.0, gain * level);
    return {noise_power + peak * peak / 2, peak};
  }
};

struct Search {
  Step last = Step::Wait;
  PathLevel found;
  std::vector<double> levels;  ///< of the level probes
  int windows = 0;
};

Search search(const Path& path, LevelSearch::Settings settings = {0.003, 0.5, Seconds{0.0}, {}}) {
  LevelSearch level{settings};
  Search result;
  std::vector<double> played;
  for (; result.windows < level.max_windows(); ++result.windows) {
    const auto captured = path.captured(played, result.windows);
    if (captured.peak > LevelSearch::kTooLoud) {
      played.resize(std::min(played.size(), static_cast<std::size_t>(result.windows)));
      level.overload();
    }
    result.last = level.observe(captured);
    if (result.last == Step::Probe) {
      result.levels.push_back(level.level());
      played.resize(static_cast<std::size_t>(result.windows) + 1);
      played.insert(played.end(), LevelSearch::kLevelProbeWindows, level.level());
    } else if (result.last != Step::Wait) {
      break;
    }
  }
  result.found = level.found();
  return result;
}

}  // namespace

TEST_CASE("level: level probes grow by 6 dB until one stands 30 dB out of the noise", "[latency][level]") {
  const auto result = search({0.1, 3, 1e-9});  // 30 dB above is 1e-6, a peak of 1.4e-3, played at 0.014
  CHECK(result.last == Step::Ready);
  CHECK(result.levels == std::vector<double>{0.003, 0.006, 0.012, 0.024});
  CHECK(result.found.level == 0.024);
  CHECK(result.found.delay->value == Approx(0.03));
}

TEST_CASE("level: what comes back late is distinguished from what comes back loud", "[latency][level]") {
  const int delay = GENERATE(20, 37, 100, 450);
  CAPTURE(delay);
  const auto result = search({0.1, delay, 1e-9});
  CHECK(result.last == Step::Ready);
  CHECK(result.found.level == 0.024);
  REQUIRE(result.found.delay);
  CHECK(result.found.delay->value == Approx(0.01 * delay));
}

TEST_CASE("level: it stays below the end of the input, even if that takes it back", "[latency][level]") {
  const double noise = 1e-3;  // 30 dB out of this is a peak of 1.4
  const auto soon = search({10.0, 2, noise});
  CHECK(soon.levels.back() == 0.048);  // comes back at 0.48, and the next would be twice that
  CHECK(soon.found.level == 0.048);
  const auto late = search({10.0, 300, noise});
  CHECK(late.levels.back() == 0.5);
  CHECK(late.last == Step::Ready);
  CHECK(late.found.level == 0.048);
}

TEST_CASE("level: where nothing is captured, what follows is as soft as the first level probe",
          "[latency][level]") {
  const auto result = search({0.0, 1, 1e-9});
  CHECK(result.last == Step::Ready);
  CHECK(result.levels.back() == 0.5);
  CHECK(result.found.level == 0.003);
  CHECK_FALSE(result.found.delay);
  CHECK(result.windows > 500);
  // 0.003 peak has a power of 4.5e-6, ten times as much as this noise.
  CHECK_FALSE(result.found.hidden_by_noise());
  CHECK(search({0.0, 1, 4.6e-7}).found.hidden_by_noise());
  CHECK_FALSE(search({0.0, 1, 4.4e-7}).found.hidden_by_noise());
}

TEST_CASE("level: when the softest level probe is too loud, that is said", "[latency][level]") {
  const auto result = search({300.0, 2, 1e-9});
  CHECK(result.last == Step::TooLoud);
  CHECK(result.found.level == 0.003);
  CHECK(result.levels.size() == 1);
}

TEST_CASE("level: an input that stays loud when nothing is played is a howl", "[latency][level]") {
  LevelSearch level{{0.003, 0.5, Seconds{0.0}, {}}};
  level.overload();
  Step step = Step::Wait;
  int windows = 0;
  for (; step == Step::Wait && windows < 100; ++windows) step = level.observe({0.5, 1.0});
  CHECK(step == Step::Feedback);
  CHECK(windows == 30);
}

TEST_CASE("level: after a known path's first level probe all is ready", "[latency][level]") {
  LevelSearch::Settings settings{0.003, 0.5, Seconds{0.0}, PathLevel{0.05, Seconds{1.0}, 1e-9}};
  const auto result = search({1.0, 100, 1e-9}, settings);
  CHECK(result.last == Step::Ready);
  CHECK(result.levels == std::vector<double>{0.05});
  CHECK(result.found.level == 0.05);
  CHECK(result.windows < 50);
}

TEST_CASE("aftermath: what is on its way when the output is muted is no howl", "[latency][level]") {
  using Result = RingOutMonitor::Result;
  RingOutMonitor late{Seconds{1.0}};
  for (int w = 0; w < 100; ++w) CHECK(late.observe({0.5, 1.0}) == Result::Nothing);
  for (int w = 0; w < 24; ++w) CHECK(late.observe({1e-9, 1e-4}) == Result::Nothing);
  CHECK(late.observe({1e-9, 1e-4}) == Result::Quiet);
}
