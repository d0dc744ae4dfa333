#include "engine/runtime/step_times.h"

#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

namespace {

constexpr int kFrames = 64;
const std::string kGraph = R"(format = 1
[networks.n]
solver = "exact"
c = { type = "chain", masses = 30, mass = "1 g", stiffness = "1 kN/m" }
f = { type = "force", on = "c.3", force = "hum * 1 N" }
ear = { type = "probe", on = "c.5" }
[nodes]
hum = { type = "sine", frequency = "100 Hz" }
[outputs]
y = { from = "n.ear.position / 1 m" }
)";

std::vector<double> run(Player& player, StepTimes* times, int blocks) {
  REQUIRE(player.prepare({48_kHz, 0, 1, kFrames}));
  std::vector<double> samples;
  ChannelBuffers out{1, kFrames};
  for (int b = 0; b < blocks; ++b) {
    player.process({nullptr, out.data(), kFrames});
    if (times != nullptr) times->add(kFrames);
    samples.insert(samples.end(), out[0], out[0] + kFrames);
  }
  return samples;
}

}  // namespace

TEST_CASE("step times: each step has one, none before the first block, and no bit of the output changes",
          "[engine]") {
  const auto plain = test::engine_of(kGraph), timed = test::engine_of(kGraph);
  StepTimes times{*timed, 2};
  CHECK(times.ns_per_frame().empty());
  CHECK(run(*timed, &times, 5) == run(*plain, nullptr, 5));
  const auto taken = times.ns_per_frame();
  REQUIRE(taken.size() == timed->plan().steps.size());
  // 60 times 60 multiplications cannot be done in no time.
  CHECK(*std::max_element(taken.begin(), taken.end()) > 0.0);
}

TEST_CASE("step times: blocks between those that are timed are not", "[engine]") {
  const auto player = test::engine_of(kGraph);
  StepTimes times{*player, 3};
  const auto sum = [&] {
    double all = 0;
    for (const double ns : player->step_nanoseconds()) all += ns;
    return all;
  };
  ChannelBuffers out{1, kFrames};
  REQUIRE(player->prepare({48_kHz, 0, 1, kFrames}));
  for (int b = 0; b < 7; ++b) {
    const double before = sum();
    player->process({nullptr, out.data(), kFrames});
    times.add(kFrames);
    CAPTURE(b);
    CHECK((sum() != before) == (b % 3 == 0));
  }
}
