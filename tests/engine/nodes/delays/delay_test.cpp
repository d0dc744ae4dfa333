#include <catch2/catch.hpp>

#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;
const std::vector<std::string> kInterpolations{"none", "linear", "lagrange3", "lagrange5"};

double frames(double count) { return count / kRate; }

NodeRunner delay_of(InputValue in, InputValue time, const std::string& interpolation,
                    std::map<std::string, Interval> ranges = {}) {
  return {test::node_type("delay"),
          {{"in", std::move(in)}, {"time", std::move(time)}},
          {{"interpolation", interpolation}},
          Hertz{kRate},
          std::move(ranges)};
}

Samples wandering(int count, double middle_frames, double depth_frames) {
  Samples time(static_cast<std::size_t>(count));
  for (std::size_t n = 0; n < time.size(); ++n)
    time[n] = frames(middle_frames + depth_frames * std::sin(0.013 * static_cast<double>(n)));
  return time;
}

}  // namespace

TEST_CASE("delay: whole frames are a copy, bit for bit", "[nodes]") {
  const int whole = GENERATE(0, 1, 2, 3, 5, 64, 100, 960, 5000);
  const auto interpolation = GENERATE(from_range(kInterpolations));
  INFO(interpolation << " " << whole);
  auto x = noise(6000, 1);
  x[10] = -0.0;
  auto runner = delay_of(x, frames(whole), interpolation);
  Samples expected(x.size(), 0.0);
  std::copy(x.begin(), x.end() - whole, expected.begin() + whole);
  const auto y = runner.run(random_cutting(6000, 1));
  if (interpolation == "none") CHECK(first_difference({expected}, y) == "");
  CHECK(y[0] == expected);
}

TEST_CASE("delay: the stated response is the measured one, down to no delay at all", "[nodes]") {
  const double delay = GENERATE(0.0, 0.3, 1.0, 1.4, 2.6, 3.5, 100.25, 700.9);
  const auto interpolation = GENERATE(from_range(kInterpolations));
  INFO(interpolation << " " << delay);
  auto runner = delay_of(impulse(1000), frames(delay), interpolation);
  const auto y = runner.run(even_cutting(1000, 64))[0];
  for (const double hertz : {0.0, 100.0, 3000.0, 11000.0, 24000.0})
    CHECK(std::abs(spectrum_at(y, hertz) - stated_response(runner, hertz, {0, frames(delay)})) < 1e-12);
}

TEST_CASE("delay: interpolation is as exact as the reference says", "[nodes]") {
  const double delay = GENERATE(100.1, 100.25, 100.5, 100.9);
  const auto gain_db = [&](const std::string& interpolation, double hertz) {
    auto runner = delay_of(0.0, frames(delay), interpolation);
    return decibels(stated_response(runner, hertz, {0, frames(delay)}));
  };
  CHECK(gain_db("linear", kRate / 20) > -0.11);
  CHECK(gain_db("lagrange3", kRate / 8) > -0.11);
  CHECK(gain_db("lagrange5", kRate / 6) > -0.11);
}

TEST_CASE("delay: any cutting gives the same bits, through process and through its halves", "[nodes]") {
  const auto interpolation = GENERATE(from_range(kInterpolations));
  INFO(interpolation);
  const InputValue time = GENERATE(InputValue{frames(80.3)}, InputValue{wandering(1500, 90, 20)},
                                   InputValue{noise(1500, 3, 0.0, 0.003)}, InputValue{frames(1.2)});
  auto runner = delay_of(noise(1500, 2), time, interpolation);
  CHECK(runner.cutting_matters(1500) == "");
  const int least = runner.node().delay(0, 0).least;
  if (least < 1) return;
  const auto whole = runner.run(even_cutting(1500, 64));
  for (unsigned seed = 0; seed < 5; ++seed)
    CHECK(first_difference(whole, runner.run_halves(random_cutting(1500, seed, std::min(least, 64)))) == "");
}

TEST_CASE("delay: the least delay is right to the frame", "[nodes]") {
  struct Row {
    double shortest;
    int none, linear, lagrange3, lagrange5;
  };
  const auto row =
      GENERATE(Row{0, 0, 0, 0, 0}, Row{0.7, 1, 0, 0, 0}, Row{1, 1, 1, 1, 1}, Row{1.6, 2, 1, 1, 1},
               Row{2, 2, 2, 1, 1}, Row{3, 3, 3, 2, 1}, Row{10.5, 11, 10, 9, 8}, Row{960, 960, 960, 959, 958});
  const int expected[] = {row.none, row.linear, row.lagrange3, row.lagrange5};
  for (std::size_t i = 0; i < kInterpolations.size(); ++i) {
    INFO(row.shortest << " " << kInterpolations[i]);
    auto runner = delay_of(impulse(2000), InputValue{frames(row.shortest)}, kInterpolations[i]);
    const int least = runner.node().delay(0, 0).least;
    CHECK(least == expected[i]);
    const auto y = runner.run(even_cutting(2000, 64))[0];
    for (int n = 0; n < least; ++n) REQUIRE(y[static_cast<std::size_t>(n)] == 0.0);
  }
}

TEST_CASE("delay: least is the least over the range of a moving time, most the most", "[nodes]") {
  auto runner =
      delay_of(noise(100, 1), wandering(100, 200, 10), "lagrange3", {{"time", {frames(150), frames(400.5)}}});
  CHECK(runner.node().delay(0, 0).least == 149);
  CHECK(runner.node().delay(0, 0).most == 401);
}

TEST_CASE("delay: a moving time reads where it says", "[nodes]") {
  // A slow sine read at a moving place: the sine there, within the error of a cubic, (w/2)^4 / 24 * 9/16 of
  // it.
  constexpr int kFrames = 4000;
  Samples x(kFrames);
  for (std::size_t n = 0; n < x.size(); ++n) x[n] = std::sin(0.05 * static_cast<double>(n));
  const auto time = wandering(kFrames, 150, 100);
  const auto y = delay_of(x, time, "lagrange3").run(even_cutting(kFrames, 64))[0];
  for (std::size_t n = 300; n < x.size(); ++n)
    REQUIRE(y[n] == Approx(std::sin(0.05 * (static_cast<double>(n) - time[n] * kRate))).margin(2e-7));
}

TEST_CASE("delay: a time outside the range is clamped and counted", "[nodes]") {
  Samples time(100, frames(20));
  time[50] = frames(5);
  time[60] = frames(90);
  time[70] = std::numeric_limits<double>::quiet_NaN();
  auto runner = delay_of(noise(100, 1), time, "none", {{"time", {frames(10), frames(40)}}});
  const auto y = runner.run(even_cutting(100, 64))[0];
  const auto x = noise(100, 1);
  CHECK(runner.node().clamped() == 3);
  CHECK(y[50] == x[40]);
  CHECK(y[60] == x[20]);
  CHECK(y[70] == x[60]);
}

TEST_CASE("delay: min and max bound what the graph does not", "[nodes]") {
  const Interval unknown{};
  NodeRunner runner{test::node_type("delay"),
                    {{"in", 0.0}, {"time", frames(100)}},
                    {{"min", "1 ms"}, {"max", "20 ms"}},
                    Hertz{kRate},
                    {{"time", unknown}}};
  CHECK(runner.node().delay(0, 0).least == 47);
  CHECK(runner.node().delay(0, 0).most == 960);
}

TEST_CASE("delay: errors are explained", "[nodes]") {
  const auto error = [](std::map<std::string, std::string> settings, Interval range) {
    return NodeRunner{test::node_type("delay"),
                      {{"in", 0.0}, {"time", 0.1}},
                      std::move(settings),
                      Hertz{kRate},
                      {{"time", range}}}
        .error();
  };
  CHECK(error({}, {}) == R"(OutOfRange max "...")");
  CHECK(error({{"max", "2 m"}}, {}) == R"(UnitMismatch 'max' "2 m" "20 ms")");
  CHECK(error({{"min", "2 s"}, {"max", "1 s"}}, {}) == "OutOfRange 'min' 'max'");
  CHECK(error({}, {0, 1000}) == "OutOfRange 1000 350 'time' 'max'");
}

TEST_CASE("event_delay: each trigger keeps the time and the value it came in with", "[nodes]") {
  // The second overtakes the first; the third comes out at once, and a time that changes later moves none.
  NodeRunner runner{test::node_type("event_delay"),
                    {{"trigger", Samples{1, 0, 1, 0, 0, 1, 0, 0}},
                     {"time", Samples{frames(6), 0, frames(2), 0, 0, frames(0), 0, 0}},
                     {"value", Samples{1, 0, 2, 0, 0, 3, 0, 0}}}};
  const auto out = runner.run(even_cutting(8, 3));
  CHECK(out[0] == Samples{0, 0, 0, 0, 1, 1, 1, 0});
  CHECK(out[1] == Samples{0, 0, 0, 0, 2, 3, 1, 1});
}
