#include "remote/osc/osc_world.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <string>
#include <vector>

#include "remote/osc/osc_world_values.h"
#include "tests/remote/osc/osc_client.h"
#include "tests/support/child_process.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::wait_until;

namespace {

using Kind = RemoteOrder::Kind;

/// Two balls, of which one is present, a block, gravity, a link and a handle.
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
  for (const char* field : {"kind", "first", "second", "x", "y", "z", "ax", "ay", "az", "bx", "by", "bz",
                            "attach", "stiffness", "damping", "effort", "effort2"})
    names.push_back(std::string{"w_link_"} + field);
  names.emplace_back("w_hand_holds");
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
    // The base has no controls; the file has another body before it that is left out.
    next->worlds = {
        {"w",
         {{{"one", "sphere", 1}, {"two", "sphere", 2}, {"block", "box", 3}, {"base", "box", 5}}, {"hand"}}}};
    description = std::move(next);
  }

  std::vector<std::string> send(const std::string& address, std::vector<OscValue> values = {}) {
    std::vector<RemoteOrder> orders;
    const auto done = world.obey({address, std::move(values)}, *description, bodies.get(), orders);
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
  std::shared_ptr<RemoteBodies> bodies;
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
  CHECK(stage.send("/world/one/grab") == kError);
  CHECK(stage.send("/world/one/mass", {1.0}) == kError);  // it is not there
  CHECK(stage.send("/world/hinge/create", {std::string{"h"}}) == kError);
  CHECK(stage.send("/world/mesh/create", {std::string{"m"}, std::string{"m.3ds"}}) == kError);
  CHECK(stage.send("/world/sphere/create") == kError);
  CHECK(stage.send("/world/sphere/create", {std::string{"a/b"}}) == kError);
  CHECK(stage.send("/world/gravity", {1.0}) == kError);
}

TEST_CASE("osc world: a joint takes a free link and is removed with it or with its body", "[remote][osc]") {
  WorldStage stage;
  const std::string two = "two", base = "base", w = "world";
  const auto hinge = [&](const std::string& name, const std::string& one, const std::string& other) {
    return stage.send("/world/hinge/create", {name, one, other, 0.1, 0.2, 0.3, 0.0, 1.0, 0.0});
  };
  const auto made = hinge("h", two, base);
  for (const char* order : {"w_link_x=0.100000", "w_link_z=0.300000", "w_link_ax=0.000000",
                            "w_link_ay=1.000000", "w_link_stiffness=0.000000", "w_link_kind=1.000000",
                            "w_link_first=2.000000", "w_link_second=5.000000"}) {
    INFO(order);
    CHECK(has(made, order));
  }
  CHECK(made.back() == "w_link_attach!");
  CHECK(hinge("h", two, w) == kError);      // it exists
  CHECK(hinge("other", two, w) == kError);  // no link is free
  CHECK(stage.send("/world/h/response/spring", {0.5, 0.25}) ==
        Texts{"w_link_stiffness=0.500000", "w_link_damping=0.250000"});
  CHECK(stage.send("/world/h/response/torque", {2.0}) == Texts{"w_link_effort=2.000000"});
  CHECK(stage.send("/world/h/response/spring", {0.5}) == kError);
  CHECK(stage.send("/world/h/position", {0.0, 0.0, 0.0}) == kError);
  CHECK(stage.send("/world/h/destroy") == Texts{"w_link_kind=0.000000", "w_link_attach!"});
  CHECK(stage.send("/world/slide/create", {std::string{"s"}, two, w, 0.0, 0.0, 1.0}).back() ==
        "w_link_attach!");
  CHECK(stage.send("/world/two/destroy") ==
        Texts{"w_link_kind=0.000000", "w_link_attach!", "w_two_present=0.000000"});
  CHECK(hinge("h", two, base) == kError);  // its body is not there
}

TEST_CASE("osc world: every kind of joint has its number and its vectors", "[remote][osc]") {
  const auto [kind, numbers, number] = GENERATE(table<std::string, int, int>({{"hinge", 6, 1},
                                                                              {"slide", 3, 2},
                                                                              {"ball", 3, 3},
                                                                              {"fixed", 0, 4},
                                                                              {"universal", 9, 5},
                                                                              {"hinge2", 9, 6},
                                                                              {"piston", 6, 7}}));
  INFO(kind);
  WorldStage stage;
  std::vector<OscValue> values{std::string{"j"}, std::string{"two"}, std::string{"base"}};
  for (int n = 0; n < numbers; ++n) values.emplace_back(0.5);
  auto too_many = values;
  too_many.emplace_back(0.5);
  CHECK(stage.send("/world/" + kind + "/create", too_many) == kError);
  CHECK(
      has(stage.send("/world/" + kind + "/create", values), "w_link_kind=" + std::to_string(double(number))));
}

TEST_CASE("osc world: grab and drop name the body of the handle", "[remote][osc]") {
  WorldStage stage;
  CHECK(stage.send("/world/two/grab") == Texts{"w_hand_holds=2.000000"});
  CHECK(stage.send("/world/base/grab") == Texts{"w_hand_holds=5.000000"});
  CHECK(stage.send("/world/drop") == Texts{"w_hand_holds=0.000000"});
}

TEST_CASE("osc world: a magnitude keeps the direction", "[remote][osc]") {
  WorldStage stage;
  CHECK(stage.send("/world/two/velocity/magnitude", {10.0}) == kError);  // not known yet
  stage.bodies = std::make_shared<RemoteBodies>(RemoteBodies{{{0, std::vector<BodyPose>(4), {}}}});
  CHECK(stage.send("/world/two/velocity/magnitude", {10.0}) == kError);  // it rests
  stage.bodies->worlds[0].bodies[1].velocity = {3, 0, -4};
  CHECK(stage.send("/world/two/velocity/magnitude", {10.0}) ==
        Texts{"w_two_vx=6.000000", "w_two_vy=0.000000", "w_two_vz=-8.000000", "w_two_launch!"});
  (void)stage.send("/world/two/force", {0.0, 2.0, 0.0});
  CHECK(stage.send("/world/two/force/magnitude", {1.0}) ==
        Texts{"w_two_fx=0.000000", "w_two_fy=1.000000", "w_two_fz=0.000000"});
}

namespace {

/// What clients are sent: "7: /world/two/position 1.00 2.00 3.00".
struct ValuesStage : WorldStage {
  bool ask(const std::string& address, std::vector<OscValue> with = {}, std::uint16_t port = 7) {
    OscPeer peer;
    peer.port = port;
    return values.ask(peer, {address, std::move(with)}, world, *description, now).has_value();
  }
  Texts after(std::chrono::milliseconds time) {
    sent.clear();
    for (auto passed = 0ms; passed < time; passed += 10ms) {
      now += 10ms;
      values.tick(world, *description, bodies.get(), now, send_it());
    }
    return sent;
  }
  OscWorldValues::Send send_it() {
    return [this](const OscPeer& peer, const OscMessage& message) {
      auto text = std::to_string(peer.port) + ": " + message.address;
      for (const auto& value : message.values)
        if (const auto* number = std::get_if<double>(&value))
          text += " " + std::to_string(*number).substr(0, *number < 0 ? 5 : 4);
        else
          text += " " + std::get<std::string>(value);
      sent.push_back(text);
    };
  }
  OscWorldValues values;
  OscWorldValues::Clock::time_point now{1h};
  Texts sent;
};

}  // namespace

TEST_CASE("osc world: get answers the sender once or at intervals until they are ended", "[remote][osc]") {
  ValuesStage stage;
  CHECK_FALSE(stage.values.wanted(stage.now).poses);
  CHECK(stage.ask("/world/two/position/get"));
  CHECK(stage.values.wanted(stage.now).poses);
  CHECK(stage.after(50ms).empty());  // nothing is known yet
  stage.bodies = std::make_shared<RemoteBodies>(RemoteBodies{{{0, std::vector<BodyPose>(4), {}}}});
  auto& two = stage.bodies->worlds[0].bodies[1];
  two.position = {1, 2, 3};
  two.velocity = {3, 0, 4};
  two.turn = {0.6, 0, 0, 0.8};  // about z
  two.size = {0.25, 0, 0};
  CHECK(stage.after(100ms) == Texts{"7: /world/two/position 1.00 2.00 3.00"});
  CHECK(stage.ask("/world/two/velocity/magnitude/get", {}, 8));
  CHECK(stage.ask("/world/two/rotation/get"));
  CHECK(stage.ask("/world/two/radius/get"));
  CHECK(stage.ask("/world/two/mass/get"));
  CHECK(stage.ask("/world/gravity/get"));
  const auto once = stage.after(50ms);
  CHECK(once.size() == 5);
  CHECK(has(once, "8: /world/two/velocity/magnitude 5.00"));
  CHECK(has(once, "7: /world/two/radius 0.25"));
  CHECK(has(once, "7: /world/two/mass 0.00"));
  CHECK(has(once, "7: /world/gravity 0.00 0.00 0.00"));
  const auto turned = std::find_if(once.begin(), once.end(), [](const auto& text) {
    return text.starts_with("7: /world/two/rotation -0.28 -0.96 0.00 0.96 -0.28");
  });
  CHECK(turned != once.end());
  CHECK(stage.ask("/world/two/position/get", {std::int64_t{30}}));
  CHECK(stage.after(300ms).size() == 11);  // at once, and ten more
  CHECK(stage.ask("/world/two/position/get", {std::int64_t{0}}));
  CHECK(stage.after(300ms).empty());
  CHECK_FALSE(stage.values.wanted(stage.now).poses);
}

TEST_CASE("osc world: get of what does not exist is an error", "[remote][osc]") {
  ValuesStage stage;
  for (const char* address :
       {"/world/nobody/position/get", "/world/two/color/get", "/world/two/get", "/world/two/density/get",
        "/world/cursor/mass/get", "/world/one/position/get"}) {
    INFO(address);
    CHECK_FALSE(stage.ask(address));
  }
  CHECK_FALSE(stage.ask("/world/two/position/get", {std::string{"x"}}));
  CHECK_FALSE(stage.ask("/world/two/position/get", {-1.0}));
  CHECK(stage.ask("/world/cursor/force/get"));
  CHECK(stage.ask("/world/base/position/get"));  // it has no controls, and a place
}

TEST_CASE("osc world: collisions are reported to those who asked by the names of the objects",
          "[remote][osc]") {
  ValuesStage stage;
  (void)stage.send("/world/sphere/create", {std::string{"a"}});
  RemoteEvent event{.kind = RemoteEvent::Kind::Impact, .value = 0, .bodies = {0, 3}, .level = 0.5};
  const auto impact = [&] {
    stage.sent.clear();
    stage.values.impact(event, stage.world, *stage.description, stage.send_it());
    return stage.sent;
  };
  CHECK(impact().empty());
  CHECK(stage.ask("/world/collide", {std::int64_t{1}}));
  CHECK(stage.ask("/world/base/collide", {std::int64_t{1}}, 8));
  CHECK(stage.ask("/world/two/collide", {std::int64_t{1}}, 9));
  CHECK_FALSE(stage.ask("/world/nobody/collide", {std::int64_t{1}}));
  CHECK(stage.values.wanted(stage.now).impacts);
  CHECK(impact() == Texts{"7: /world/collide a base 0.50", "8: /world/base/collide a 0.50"});
  CHECK(stage.ask("/world/collide", {std::int64_t{0}}));
  OscPeer eight;
  eight.port = 8;
  stage.values.forget(eight);
  CHECK(impact().empty());
}

#if defined(TACTUS_HAS_ODE)

TEST_CASE("osc world: a client makes bodies of a running instrument, joins them and reads them back",
          "[remote][live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("pool.toml", R"(format = 1
name = "pool"
[worlds.w]
ball = { type = "sphere", radius = "2 cm", mass = "30 g", present = 0, remote = "yes" }
other = { type = "sphere", radius = "2 cm", mass = "30 g", present = 0, remote = "yes" }
link = { type = "link", remote = "yes" }
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
  client.send({"/world/a/position/get"});
  const auto place = client.wait_for("/world/a/position");
  REQUIRE(place);
  CHECK(std::get<double>(place->values.at(0)) == Approx(0.4));
  // A hinge about z through the origin: launched along y, it goes round at a distance of 0.4 m.
  client.send({"/world/hinge/create",
               {std::string{"h"}, std::string{"a"}, std::string{"world"}, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}});
  client.send({"/world/a/velocity", {0.0, 4.0, 0.0}});
  client.send({"/world/a/position/magnitude/get", {std::int64_t{10}}});
  client.send({"/world/a/acceleration/magnitude/get", {std::int64_t{10}}});
  // v^2 / r
  CHECK(wait_until([&] {
    const auto message = client.wait_for("/world/a/acceleration/magnitude");
    return message && std::get<double>(message->values.at(0)) == Approx(40.0).epsilon(0.01);
  }));
  const auto distance = client.wait_for("/world/a/position/magnitude");
  REQUIRE(distance);
  CHECK(std::get<double>(distance->values.at(0)) == Approx(0.4).epsilon(0.001));
  // A second body in its way.
  client.send({"/world/collide", {std::int64_t{1}}});
  client.send({"/world/sphere/create", {std::string{"b"}, -0.4, 0.0, 0.0}});
  const auto collision = client.wait_for("/world/collide");
  REQUIRE(collision);
  CHECK(std::get<std::string>(collision->values.at(0)) == "a");
  CHECK(std::get<std::string>(collision->values.at(1)) == "b");
  CHECK(std::get<double>(collision->values.at(2)) > 0.1);
  process.send(SIGTERM);
  CHECK(process.wait(60s).value_or(-1) == 5);
}

#endif
