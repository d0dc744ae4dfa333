#include "remote/osc/osc_world.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <string>
#include <vector>

#include "tests/remote/osc/osc_client.h"
#include "tests/support/child_process.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::wait_until;

namespace {

using Kind = RemoteOrder::Kind;

/// Two balls, of which one is present, a block, and gravity.
std::vector<std::string> world_controls() {
  std::vector<std::string> names;
  for (const std::string body : {"w_one", "w_two", "w_block"}) {
    for (const char* field : {"_present", "_place", "_launch", "_x", "_y", "_z", "_vx", "_vy", "_vz", "_fx",
                              "_fy", "_fz", "_mass"})
      names.push_back(body + field);
    if (body == "w_block")
      for (const char* size : {"_width", "_depth", "_height"}) names.push_back(body + size);
    else
      names.push_back(body + "_radius");
  }
  for (const char* axis : {"x", "y", "z"}) names.push_back(std::string{"w_gravity_"} + axis);
  return names;
}

/// Orders as texts: "w_one_x=0.5", "w_one_place!".
struct WorldStage {
  WorldStage() {
    const auto names = world_controls();
    auto next = std::make_shared<RemoteDescription>(
        RemoteDescription{"test", std::vector<RemoteControl>(names.size()), {}, {}, {}, {}});
    for (std::size_t c = 0; c < names.size(); ++c) {
      auto& control = next->controls[c];
      control.name = names[c];
      control.number = static_cast<int>(c);
      control.low = names[c].ends_with("radius") ? 0.001 : -1e6;
      control.high = 1e6;
      control.value = names[c] == "w_two_present" ? 1.0 : 0.0;
    }
    description = std::move(next);
  }

  std::vector<std::string> send(const std::string& address, std::vector<OscValue> values = {}) {
    std::vector<RemoteOrder> orders;
    const auto done = world.obey({address, std::move(values)}, *description, orders);
    if (!done) return {"error"};
    std::vector<std::string> texts;
    for (const auto& order : orders) {
      const auto& control = description->controls[static_cast<std::size_t>(order.number)];
      texts.push_back(control.name + (order.kind == Kind::Trigger ? "!" : "=" + std::to_string(order.value)));
      if (order.kind == Kind::Set) control.value = order.value;
    }
    return texts;
  }

  std::shared_ptr<const RemoteDescription> description;
  OscWorld world;
};

using Texts = std::vector<std::string>;
const Texts kError = {"error"};

bool has(const Texts& texts, const std::string& text) {
  return std::find(texts.begin(), texts.end(), text) != texts.end();
}

}  // namespace

TEST_CASE("osc world: a created object takes a free body, and gives it back when it is destroyed",
          "[remote][osc]") {
  WorldStage stage;
  const auto made = stage.send("/world/sphere/create", {std::string{"a"}, 0.5, std::int64_t{1}, 0.25});
  for (const char* order : {"w_one_x=0.500000", "w_one_y=1.000000", "w_one_z=0.250000", "w_one_vx=0.000000",
                            "w_one_fz=0.000000", "w_one_present=1.000000", "w_one_place!", "w_one_launch!"}) {
    INFO(order);
    CHECK(has(made, order));
  }
  CHECK(stage.send("/world/sphere/create", {std::string{"b"}}) == kError);  // the other one is present
  CHECK(stage.send("/world/sphere/create", {std::string{"a"}}) == kError);  // it exists
  CHECK(stage.send("/world/prism/create", {std::string{"b"}}).size() == 12);
  CHECK(stage.send("/world/b/size", {0.1, 0.2, 0.3}) ==
        Texts{"w_block_width=0.100000", "w_block_depth=0.200000", "w_block_height=0.300000"});
  CHECK(stage.send("/world/a/destroy") == Texts{"w_one_present=0.000000"});
  CHECK(stage.send("/world/a/destroy") == kError);
  CHECK(has(stage.send("/world/sphere/create", {std::string{"c"}}), "w_one_x=0.000000"));
  CHECK(stage.send("/world/clear") == Texts{"w_block_present=0.000000", "w_one_present=0.000000"});
}

TEST_CASE("osc world: objects and gravity are changed by DIMPLE's messages", "[remote][osc]") {
  WorldStage stage;
  CHECK(stage.send("/world/two/position", {1.0, 2.0, 3.0}) ==
        Texts{"w_two_x=1.000000", "w_two_y=2.000000", "w_two_z=3.000000", "w_two_place!"});
  CHECK(stage.send("/world/two/velocity", {1.0, 2.0, 3.0}).back() == "w_two_launch!");
  CHECK(stage.send("/world/two/force", {1.0, 2.0, 3.0}) ==
        Texts{"w_two_fx=1.000000", "w_two_fy=2.000000", "w_two_fz=3.000000"});
  CHECK(stage.send("/world/two/mass", {0.5}) == Texts{"w_two_mass=0.500000"});
  CHECK(stage.send("/world/two/radius", {0.0}) == Texts{"w_two_radius=0.001000"});  // the least of its range
  CHECK(stage.send("/world/gravity", {0.0, 0.0, -1.5}).back() == "w_gravity_z=-1.500000");
}

TEST_CASE("osc world: what makes no sense gives an error and no order", "[remote][osc]") {
  WorldStage stage;
  CHECK(stage.send("/world/two/position", {1.0, 2.0}) == kError);
  CHECK(stage.send("/world/two/position", {1.0, 2.0, std::string{"x"}}) == kError);
  CHECK(stage.send("/world/two/density", {1.0}) == kError);
  CHECK(stage.send("/world/two/size", {1.0, 1.0, 1.0}) == kError);
  CHECK(stage.send("/world/two/grab") == kError);
  CHECK(stage.send("/world/one/mass", {1.0}) == kError);  // it is not there
  CHECK(stage.send("/world/hinge/create", {std::string{"h"}}) == kError);
  CHECK(stage.send("/world/sphere/create") == kError);
  CHECK(stage.send("/world/sphere/create", {std::string{"a/b"}}) == kError);
  CHECK(stage.send("/world/gravity", {1.0}) == kError);
}

#if defined(TACTUS_HAS_ODE)

TEST_CASE("osc world: a client makes a body of a running instrument and moves it", "[remote][live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("pool.toml", R"(format = 1
name = "pool"
[worlds.w]
ball = { type = "sphere", radius = "2 cm", mass = "30 g", present = 0, remote = "yes" }
gravity = { type = "gravity", z = 0 }
[nodes]
tone = { type = "sine", frequency = "480 Hz" }
[outputs]
out = { from = "tone * w.ball.x / 1 m", kind = "audio" }
)");
  test::ChildProcess process({"sh", "-c", "exec \"$0\" \"$@\" </dev/null", TACTUS_PROGRAM, "play",
                              file.string(), "--backend", "loop", "--osc", "0", "--arm"},
                             test::ChildProcess::Stdout::Logged);
  const std::string opened = "OSC       udp 127.0.0.1:";
  REQUIRE(wait_until([&] { return process.log().find(opened) != std::string::npos; }));
  const auto text = process.log();
  test::OscClient client{std::stoi(text.substr(text.find(opened) + opened.size()))};
  client.send({"/subscribe", {std::string{"/control/w_ball_x"}, 50.0}});
  client.send({"/world/sphere/create", {std::string{"a"}, 0.25, 0.0, 0.0}});
  const auto reads = [&](const char* address, double wanted) {
    return wait_until([&] {
      const auto message = client.wait_for(address);
      return message && std::get<double>(message->values.at(0)) == Approx(wanted).epsilon(1e-4);
    });
  };
  CHECK(reads("/control/w_ball_x", 0.25));
  client.send({"/subscribe", {std::string{"/level/out/out"}, 50.0}});
  CHECK(reads("/level/out/out", 0.25));
  client.send({"/world/a/position", {0.4, 0.0, 0.0}});
  CHECK(reads("/level/out/out", 0.4));
  client.send({"/world/nobody/position", {0.4, 0.0, 0.0}});
  CHECK(client.wait_for("/error"));
  process.send(SIGTERM);
  CHECK(process.wait(60s).value_or(-1) == 5);
}

#endif
