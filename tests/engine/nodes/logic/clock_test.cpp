#include <catch2/catch.hpp>

#include "tests/support/graphs/node_runner.h"
#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::Samples;

namespace {

std::vector<int> frames_of(const Samples& triggers) {
  std::vector<int> frames;
  for (std::size_t n = 0; n < triggers.size(); ++n)
    if (triggers[n] == 1) frames.push_back(static_cast<int>(n));
  return frames;
}

test::Outputs clock(int frames, const std::map<std::string, test::InputValue>& inputs) {
  test::NodeRunner runner(test::node_type("clock"), inputs);
  REQUIRE(runner.error().empty());
  return runner.run(test::random_cutting(frames, 7));
}

}  // namespace

TEST_CASE("clock: steps lie where tempo, division and swing put them", "[nodes]") {
  // 120 beats a minute are 24000 frames each.
  CHECK(frames_of(clock(60000, {{"tempo", 2.0}})[0]) == std::vector{0, 24000, 48000});
  CHECK(frames_of(clock(20000, {{"tempo", 2.0}, {"division", 4.0}})[0]) ==
        std::vector{0, 6000, 12000, 18000});
  CHECK(frames_of(clock(30000, {{"tempo", 2.0}, {"division", 4.0}, {"swing", 2.0 / 3}})[0]) ==
        std::vector{0, 8000, 12000, 20000, 24000});
  CHECK(frames_of(clock(1000, {{"tempo", 0.0}})[0]) == std::vector{0});
}

TEST_CASE("clock: a step of a whole number of frames never comes late", "[nodes]") {
  // 33.33 Hz has no exact value in binary.
  const auto frames = frames_of(clock(720'000, {{"tempo", 100.0 / 3}})[0]);
  REQUIRE(frames.size() == 500);
  for (std::size_t k = 0; k < frames.size(); ++k) CHECK(frames[k] == 1440 * static_cast<int>(k));
}

TEST_CASE("clock: a reset starts a pair of steps, phase and count follow", "[nodes]") {
  Samples reset(40);
  reset[25] = 1;
  const auto out = clock(40, {{"tempo", 4800.0}, {"swing", 0.7}, {"reset", reset}});
  CHECK(frames_of(out[0]) == std::vector{0, 14, 20, 25, 39});
  CHECK(out[2][13] == 0);
  CHECK(out[2][14] == 1);
  CHECK(out[2][25] == 0);
  CHECK(out[1][7] == Approx(0.5));
  CHECK(out[1][17] == Approx(0.5));
  CHECK(out[1][25] == 0);
}

TEST_CASE("clock: a change of tempo keeps the part of the beat that has passed", "[nodes]") {
  Samples tempo(40, 4800.0);  // 10 frames
  for (std::size_t n = 5; n < tempo.size(); ++n) tempo[n] = 2400;
  CHECK(frames_of(clock(40, {{"tempo", tempo}})[0]) == std::vector{0, 15, 35});
}

TEST_CASE("sequence: one value at each trigger, and a zero is a rest", "[nodes]") {
  const Samples trigger{0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0}, reset{0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
  test::NodeRunner runner(test::node_type("sequence"), {{"trigger", trigger}, {"reset", reset}},
                          {{"values", "[3, 0, -1]"}});
  const auto out = runner.run(std::vector{4, 7});
  CHECK(out[0] == Samples{3, 3, 3, 0, 0, -1, -1, 3, 3, 3, 3});
  CHECK(out[1] == Samples{0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0});
  CHECK(out[2] == Samples{0, 0, 0, 1, 1, 2, 2, 0, 0, 0, 0});
}

TEST_CASE("toggle: changes at each trigger, and a reset wins", "[nodes]") {
  CHECK(test::play_node(test::node_type("toggle"), 8,
                        {{"trigger", Samples{1, 0, 1, 0, 1, 1, 0, 1}},
                         {"reset", Samples{0, 0, 0, 0, 0, 1, 0, 0}}}) == Samples{1, 1, 0, 0, 1, 0, 0, 1});
}
