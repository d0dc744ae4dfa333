#include "apps/play/live/controls/live_controls.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using app::LiveControls;

namespace {

const std::string kGraph = R"(
format = 1
[controls]
plain = { value = 0.5, range = [-1, 3] }
loud  = { value = "-30 dB", range = ["-60 dB", "0 dB"] }
[outputs]
y = { from = "plain" }
z = { from = "loud" }
)";

/// A player of two outputs and no inputs, prepared.
class Playback {
 public:
  explicit Playback(Player& player) : player_(player) {
    REQUIRE(player_.prepare({player_.plan().sample_rate, 0, 2, 4096}));
  }
  /// The next frames.
  test::Channels run(int frames) {
    test::Channels out(2, std::vector<double>(static_cast<std::size_t>(frames)));
    double* to[] = {out[0].data(), out[1].data()};
    player_.process({nullptr, to, frames});
    return out;
  }

 private:
  Player& player_;
};

}  // namespace

TEST_CASE("live controls: one goes over its range, in decibels where the control does", "[live]") {
  const auto engine = test::engine_of(kGraph);
  LiveControls controls{*engine};
  REQUIRE(controls.all().size() == 2);
  CHECK(controls.position(0) == Approx((0.5 + 1) / 4));
  CHECK(controls.position(1) == Approx(0.5));
  REQUIRE(controls.turn(1, 0.75));
  CHECK(20 * std::log10(controls.all()[1].control.value) == Approx(-15.0));
  CHECK(controls.text(1) == "loud = -15 dB");
  REQUIRE(controls.nudge(0, 0.25));
  CHECK(controls.all()[0].control.value == Approx(1.5));
}

TEST_CASE("live controls: one stops at its ends", "[live]") {
  const auto engine = test::engine_of(kGraph);
  LiveControls controls{*engine};
  REQUIRE(controls.nudge(0, 7.0));
  CHECK(controls.all()[0].control.value == 3.0);
  REQUIRE(controls.nudge(0, -7.0));
  CHECK(controls.all()[0].control.value == -1.0);
}

TEST_CASE("live controls: the player receives the last value", "[live]") {
  const auto player = test::engine_of(kGraph);
  LiveControls controls{*player};
  REQUIRE(controls.turn(0, 0.5));
  REQUIRE(controls.turn(0, 1.0));
  controls.send();
  CHECK(Playback{*player}.run(1000)[0][999] == 3.0);
}

TEST_CASE("live controls: no number of changes is too many while no block is processed", "[live]") {
  const auto player = test::engine_of(kGraph);
  LiveControls controls{*player};
  for (int change = 0; change <= 1000; ++change) {
    REQUIRE(controls.turn(0, change / 1000.0));
    controls.send();  // the queue of the player is full after 256
  }
  Playback playback{*player};
  CHECK(playback.run(1000)[0][999] < 3.0);
  controls.send();
  CHECK(playback.run(1000)[0][999] == 3.0);
}

TEST_CASE("live controls: after a return of the device the player starts at the shown values, without a ramp",
          "[live]") {
  const auto player = test::engine_of(kGraph);
  LiveControls controls{*player};
  REQUIRE(controls.turn(0, 0.75));
  controls.send();
  REQUIRE(controls.turn(0, 0.0));
  REQUIRE(controls.turn(1, 1.0));
  Playback back{*player};
  controls.post_all();
  const auto out = back.run(1000);
  CHECK(out[0] == std::vector<double>(1000, -1.0));
  CHECK(out[1] == std::vector<double>(1000, 1.0));
}

TEST_CASE("live controls: an edit moves a control only if its value in the file changed", "[live]") {
  const auto player = test::engine_of(kGraph);
  LiveControls controls{*player};
  Playback playback{*player};
  REQUIRE(controls.turn(0, 0.75));  // 2
  REQUIRE(controls.turn(1, 1.0));   // 0 dB
  controls.send();
  playback.run(1000);
  // The range of the first is smaller now, the second has another value.
  auto edited = kGraph;
  edited.replace(edited.find("3]"), 2, "1.5]");
  edited.replace(edited.find("-30"), 3, "-40");
  REQUIRE(player->replace(*compile(parse_graph_leniently(edited, "test.toml"), standard_nodes(), {})));
  controls.renew();
  const auto out = playback.run(2000);
  CHECK(out[0][1999] == 1.5);
  CHECK(out[1][1999] == Approx(0.01));
  CHECK(controls.all()[0].control.value == out[0][1999]);
  CHECK(controls.all()[1].control.value == out[1][1999]);
}

TEST_CASE("live controls: a value is shown in the unit of its file", "[live]") {
  const auto engine = test::engine_of(R"(
format = 1
[controls]
tempo = { value = "120 rpm", range = ["30 rpm", "240 rpm"] }
pitch = { value = "2 Hz", range = ["1 Hz", "4 Hz"] }
[outputs]
y = { from = "tempo + pitch", unit = "Hz" }
z = { from = "tempo", unit = "Hz" }
)");
  const LiveControls controls{*engine};
  CHECK(controls.text(0) == "tempo = 120 rpm");
  CHECK(controls.text(1) == "pitch = 2 Hz");
}
