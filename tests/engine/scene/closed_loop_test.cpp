#include "engine/scene/closed_loop.h"

#include <catch2/catch.hpp>

#include "tests/support/allocation_count.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;

namespace {

std::string graph(const std::string& body) { return "format = 1\nname = \"test\"\n" + body; }

const std::string kIdentity = graph("[inputs]\nx = {}\n[outputs]\ny = { from = \"x\" }\n");

/// A plant whose sensor hears itself: a wave that repeats its own numbers and the drive behind it.
const std::string kPlant = graph(R"([inputs]
drive = {}
[nodes]
count = { type = "sine", frequency = "111 Hz", level = 0.5 }
[outputs]
sensor = { from = "count" }
)");

struct Played {
  test::Samples sensor, drive, felt;
};

Played play(int delay, int block, Converters converters, const std::string& plant_text = kPlant) {
  constexpr int kFrames = 3000;
  const auto instrument = test::engine_of(kIdentity);
  CompileOptions options;
  options.taps = {"drive"};
  options.closed_outside = delay == 0;
  const auto plant = test::engine_of(plant_text, options);
  ClosedLoop loop{*instrument, *plant, 1, delay, converters};
  REQUIRE(loop.prepare(48_kHz, block));
  Played played;
  loop.run(kFrames, [&](const ClosedLoop::Block& piece) {
    for (int n = 0; n < piece.frames; ++n) {
      played.sensor.push_back(piece.sensors[0][n]);
      played.drive.push_back(piece.drives[0][n]);
      played.felt.push_back(plant->tap(0)[n]);
    }
  });
  return played;
}

}  // namespace

TEST_CASE("ClosedLoop: the plant feels after exactly D frames what an identity instrument received",
          "[scene]") {
  for (const bool on : {false, true})
    for (const int delay : {0, 1, 2, 47, 48, 64, 65, 480, 960})
      for (const int block : {1, 48, 64, 1000}) {
        INFO("D = " << delay << ", blocks of " << block << ", converters " << on);
        const auto played = play(delay, block, {.on = on, .bits = 12});
        REQUIRE(played.felt.size() == 3000);
        CHECK(test::first_difference({played.sensor}, {played.drive}) == "");
        const auto d = static_cast<std::size_t>(delay);
        bool exact = true;
        for (std::size_t n = 0; n < played.felt.size(); ++n)
          exact = exact && played.felt[n] == (n < d ? 0 : played.drive[n - d]);
        CHECK(exact);
      }
}

TEST_CASE("ClosedLoop: the recording is behind the converters at any delay", "[scene]") {
  for (const int delay : {0, 1, 100}) {
    INFO("D = " << delay);
    for (const double sample : play(delay, 64, {.on = true, .bits = 4}).sensor)
      REQUIRE(sample * 8 == std::nearbyint(sample * 8));
  }
}

TEST_CASE("ClosedLoop: a sensor of full scale clips, and one with a unit does not", "[scene]") {
  const auto largest = [](const std::string& level, const std::string& unit) {
    const auto sensor =
        play(1, 64, {.on = true, .bits = 12},
             graph("[inputs]\ndrive = {}\n[nodes]\nwave = { type = \"sine\", frequency = \"120 Hz\", "
                   "level = \"" +
                   level + "\" }\n[outputs]\nsensor = { from = \"wave\"" + unit + " }\n"))
            .sensor;
    return *std::max_element(sensor.begin(), sensor.end());
  };
  CHECK(largest("2.5", "") == 2047.0 / 2048);
  CHECK(largest("2.5 rad", ", unit = \"rad\"") == 2.5);
  CHECK(largest("2.5 m", ", unit = \"m\"") == 2.5);
}

TEST_CASE("ClosedLoop: without delay a plant's state closes the loop within the frame", "[scene]") {
  // x[n] = start[n] - 0.5 x[n - 1]: the drive of frame n is the sensor of frame n.
  const auto played = play(0, 64, {.on = false, .bits = 24}, graph(R"([inputs]
drive = {}
[nodes]
start = { type = "noise", level = 1 }
last  = { type = "delay", in = "drive", time = "1 / system.rate", interpolation = "none" }
[outputs]
sensor = { from = "start - 0.5 * last" }
start  = { from = "start" }
)"));
  const auto start = test::run(*test::engine_of(graph("[nodes]\nstart = { type = \"noise\", level = 1 }\n"
                                                      "[outputs]\ny = { from = \"start\" }\n")),
                               {}, 3000, {64})[0];
  double last = 0;
  for (std::size_t n = 0; n < start.size(); ++n) {
    const double x = start[n] - 0.5 * last;
    REQUIRE(played.sensor[n] == x);
    last = x;
  }
}

TEST_CASE("ClosedLoop: a plant that feels the drive in its sensor at once needs a frame of delay",
          "[scene]") {
  const auto feedthrough = graph("[inputs]\ndrive = {}\n[outputs]\nsensor = { from = \"0.5 * drive\" }\n");
  CompileOptions options;
  CHECK(test::errors_of(feedthrough, options) == "");
  options.closed_outside = true;
  CHECK(test::errors_of(feedthrough, options) == "test.toml:4:1 Cycle drive -> sensor -> drive");
  // A tap may: nobody outside answers it.
  options.taps = {"felt"};
  CHECK(test::errors_of(graph("[inputs]\ndrive = {}\n[nodes]\nfelt = \"0.5 * drive\"\n"
                              "[outputs]\nsensor = { from = \"1\" }\n"),
                        options) == "");
}

TEST_CASE("ClosedLoop: a plant that breaks without delay drops no frame of the instrument", "[scene]") {
  const auto instrument = test::engine_of(kIdentity);
  CompileOptions options;
  options.closed_outside = true;
  // Doubles 10 times a frame and more: overflows after some hundred frames, again and again.
  const auto plant = test::engine_of(graph(R"([inputs]
drive = {}
[nodes]
grown = { type = "delay", in = "1 + 1e10 * drive", time = "1 / system.rate", interpolation = "none" }
[outputs]
sensor = { from = "grown * 10" }
)"),
                                     options);
  ClosedLoop loop{*instrument, *plant, 1, 0, {.on = false, .bits = 24}};
  REQUIRE(loop.prepare(48_kHz, 64));
  bool finite = true;
  loop.run(1000,
           [&](const ClosedLoop::Block& piece) { finite = finite && std::isfinite(piece.sensors[0][0]); });
  CHECK(finite);
  CHECK_FALSE(plant->faults().empty());
  CHECK(plant->frame() == 1000);
  CHECK(instrument->frame() == 1000);
}

TEST_CASE("ClosedLoop: what is not finite in the answer is counted and read as zero", "[scene]") {
  class Broken final : public BlockProcessor {
    Status prepare(const StreamFormat&) override { return {}; }
    void process(const BlockIo& io) noexcept override {
      for (int n = 0; n < io.frames; ++n) io.out[0][n] = std::numeric_limits<double>::quiet_NaN();
    }
  };
  for (const int delay : {0, 3}) {
    Broken instrument;
    CompileOptions options;
    options.closed_outside = delay == 0;
    const auto plant = test::engine_of(kPlant, [&] {
      auto with_tap = options;
      with_tap.taps = {"drive"};
      return with_tap;
    }());
    ClosedLoop loop{instrument, *plant, 1, delay, {.on = false, .bits = 24}};
    REQUIRE(loop.prepare(48_kHz, 1));
    bool zero = true;
    loop.run(100, [&](const ClosedLoop::Block&) { zero = zero && plant->tap(0)[0] == 0; });
    CHECK(zero);
    CHECK(plant->bad_input_samples() == 100 - delay);
    CHECK(plant->faults().empty());
  }
}
