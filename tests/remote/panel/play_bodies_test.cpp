// The program itself, with a world, and a browser that watches it.
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <set>
#include <string>

#include "tests/remote/panel/browser_client.h"
#include "tests/support/child_process.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

#if defined(TACTUS_HAS_ODE)

using namespace tactus;
using namespace std::chrono_literals;
using test::Json;
using test::wait_until;

TEST_CASE("play: a browser that asks for them sees the bodies of a world move", "[remote][live]") {
  const test::TemporaryFolder folder;
  // A ball on a hinge about z, 30 cm away, at 2 m/s: it goes round for ever. The block begins absent.
  const auto file = folder.write("round.toml", R"(format = 1
name = "round"
[worlds.hall]
ball = { type = "sphere", radius = "2 cm", mass = "30 g", x = "30 cm", vy = "2 m/s" }
axis = { type = "hinge", on = "ball", axis = [0, 0, 1] }
floor = { type = "plane", normal = [0, 0, 2], offset = "-1 m" }
block = { type = "box", width = "2 cm", depth = "4 cm", height = "6 cm", mass = 1, y = "1 m", present = 0, remote = "yes" }
hand = { type = "handle", on = "ball", z = "0 m", stiffness = "1 N/m", damping = "0 N s/m" }
[outputs]
out = { from = "hall.ball.x / 1 m + hall.hand.fz / 1 N", kind = "audio" }
)");
  test::ChildProcess process({"sh", "-c", "exec \"$0\" \"$@\" </dev/null", TACTUS_PROGRAM, "play",
                              file.string(), "--backend", "loop", "--panel", "--no-browser"},
                             test::ChildProcess::Stdout::Logged);
  const std::string opened = "panel     ";
  REQUIRE(wait_until([&] { return process.log().find(opened + "http://127.0.0.1:") != std::string::npos; }));
  const auto text = process.log();
  const auto at = text.find("http://127.0.0.1:");
  const auto link = text.substr(at, text.find('\n', at) - at);
  test::BrowserClient browser{test::port_of(link)};
  REQUIRE(browser.open(link));

  const auto description = browser.wait_for("description");
  REQUIRE(description["worlds"].size() == 1);
  const auto& world = description["worlds"][0];
  CHECK(world["name"] == "hall");
  REQUIRE(world["bodies"].size() == 3);
  CHECK(world["bodies"][0] ==
        Json{{"name", "ball"}, {"shape", "sphere"}, {"moves", true}, {"normal", {0, 0, 1}}, {"offset", 0}});
  CHECK(world["bodies"][1]["shape"] == "plane");
  CHECK(world["bodies"][1]["normal"] == Json{0, 0, 2});
  CHECK(world["bodies"][1]["offset"] == -1);
  CHECK(world["handles"] == Json{"hand"});
  CHECK_FALSE(browser.wait_for("state").contains("bodies"));

  const auto bodies = [&] {
    Json found;
    REQUIRE(wait_until([&] {
      found = browser.wait_for("state");
      return found.contains("bodies");
    }));
    return found["bodies"][0];
  };
  browser.send(R"({"do":"bodies","on":true})");
  std::set<double> places;
  for (int n = 0; n < 5; ++n) {
    const auto shown = bodies();
    REQUIRE(shown["bodies"].size() == 3);
    const auto ball = shown["bodies"][0].get<std::vector<double>>();
    REQUIRE(ball.size() == 10);
    CHECK(std::hypot(ball[0], ball[1]) == Approx(0.3).epsilon(1e-3));
    // It turns with the hinge: the quaternion of the angle of its place, up to its sign.
    const double angle = std::atan2(ball[1], ball[0]);
    CHECK(std::abs(ball[3] * std::cos(angle / 2) + ball[6] * std::sin(angle / 2)) ==
          Approx(1.0).epsilon(1e-3));
    CHECK(ball[7] == 0.02);
    CHECK(shown["bodies"][2].is_null());
    CHECK(shown["handles"][0][3] == 0);
    places.insert(ball[0]);
  }
  CHECK(places.size() > 1);
  browser.send(R"({"do":"set","name":"hall_block_present","value":1})");
  CHECK(wait_until([&] { return bodies()["bodies"][2].is_array(); }));
  CHECK(bodies()["bodies"][2] == Json{0, 1, 0, 1, 0, 0, 0, 0.02, 0.04, 0.06});
  browser.send(R"({"do":"bodies","on":false})");
  CHECK(wait_until([&] { return !browser.wait_for("state").contains("bodies"); }));
  process.send(SIGTERM);
  CHECK(process.wait(60s).value_or(-1) == 5);
}

#endif
