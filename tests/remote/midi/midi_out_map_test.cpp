#include "remote/midi/midi_out_map.h"

#include <catch2/catch.hpp>

#include "tests/remote/fake_remote_target.h"

using namespace tactus;
using namespace std::chrono_literals;
using Kind = RigMidiOut::Kind;
using Bytes = std::vector<std::uint8_t>;

namespace {

RemoteEvent hit(double level) {
  RemoteEvent event{.kind = RemoteEvent::Kind::Trigger, .level = level};
  std::string{"hit"}.copy(event.text, sizeof event.text - 1);
  return event;
}

struct Stage {
  explicit Stage(std::vector<RigMidiOut> bindings)
      : map{std::move(bindings),
            [this](std::span<const std::uint8_t> bytes) { sent.emplace_back(bytes.begin(), bytes.end()); }} {}
  void pass(std::chrono::microseconds time) {
    for (const auto end = now + time; now < end;) {
      now += 1ms;
      map.tick(*target.description(), now);
    }
  }
  std::vector<Bytes> take() { return std::exchange(sent, {}); }

  test::FakeRemoteTarget target;
  std::vector<Bytes> sent;
  MidiOutMap::Clock::time_point now{};
  MidiOutMap map;
};

}  // namespace

TEST_CASE("midi out: velocity is the level in decibels between the softest and the loudest", "[remote]") {
  const RigMidiOut binding{.name = "hit", .at = {}, .softest = 0.01, .loudest = 1.0};  // -40 dB to 0 dB
  CHECK(MidiOutMap::velocity(0.0, binding) == 1);
  CHECK(MidiOutMap::velocity(0.01, binding) == 1);
  CHECK(MidiOutMap::velocity(0.1, binding) == 64);  // halfway
  CHECK(MidiOutMap::velocity(1.0, binding) == 127);
  CHECK(MidiOutMap::velocity(50.0, binding) == 127);
  CHECK(MidiOutMap::velocity(std::nan(""), binding) == 1);
}

TEST_CASE("midi out: an event is a note that ends after its length", "[remote]") {
  Stage stage{{{.name = "hit", .at = {}, .channel = 10, .number = 38, .length = 50_ms},
               {.name = "other", .at = {}, .number = 40}}};
  stage.map.event(hit(1.0), stage.now);
  CHECK(stage.take() == std::vector<Bytes>{{0x99, 38, 127}});
  REQUIRE(stage.map.due());
  CHECK(*stage.map.due() == stage.now + 50ms);
  stage.pass(49ms);
  CHECK(stage.take().empty());
  stage.pass(1ms);
  CHECK(stage.take() == std::vector<Bytes>{{0x89, 38, 0}});
  CHECK_FALSE(stage.map.due());
}

TEST_CASE("midi out: a note that sounds still ends before it begins again, and at the end", "[remote]") {
  Stage stage{{{.name = "hit", .at = {}, .number = 38}}};
  stage.map.event(hit(1.0), stage.now);
  stage.pass(10ms);
  stage.map.event(hit(0.1), stage.now);
  CHECK(stage.take() == std::vector<Bytes>{{0x90, 38, 127}, {0x80, 38, 0}, {0x90, 38, 64}});
  stage.map.stop();
  CHECK(stage.take() == std::vector<Bytes>{{0x80, 38, 0}});
}

TEST_CASE("midi out: a control sends a controller when it moved by a step", "[remote]") {
  Stage stage{{{.name = "strength", .at = {}, .kind = Kind::Controller, .number = 7},
               {.name = "level", .at = {}, .channel = 2, .kind = Kind::Controller, .number = 11}}};
  const auto& controls = stage.target.description()->controls;
  stage.pass(1ms);
  CHECK(stage.take() == std::vector<Bytes>{{0xb0, 7, 127}, {0xb1, 11, 127}});
  controls[0].value = 0.5;
  controls[2].value = 0.0317;  // just above -30 dB of -60 to 0 dB
  stage.pass(2ms);
  CHECK(stage.take() == std::vector<Bytes>{{0xb0, 7, 64}, {0xb1, 11, 64}});
  controls[0].value = 0.501;
  stage.pass(5ms);
  CHECK(stage.take().empty());
}

TEST_CASE("midi out: a control in Hz gives 24 pulses a beat", "[remote]") {
  Stage stage{{{.name = "fixed", .at = {}, .kind = Kind::Clock, .per_beat = 1}}};
  stage.target.description()->controls[3].value = 0.5;  // Hz: 12 pulses a second
  stage.pass(1ms);
  CHECK(stage.take() == std::vector<Bytes>{{0xfa}, {0xf8}});
  stage.pass(10s);
  CHECK(stage.take().size() == 120);
  stage.target.description()->controls[3].value = 1.0;  // from the next pulse on
  stage.pass(10s);
  CHECK(stage.take().size() == Approx(240).margin(1));
  stage.now += 1s;  // pulses that were missed are not sent all at once
  stage.pass(1ms);
  CHECK(stage.take().size() == 1);
  stage.target.description()->controls[3].value = 0.0;
  stage.pass(1ms);
  CHECK(stage.take() == std::vector<Bytes>{{0xfc}});
  stage.map.stop();
  CHECK(stage.take().empty());
}

TEST_CASE("midi out: names that the instrument does not have, and a clock without a frequency, are errors",
          "[remote]") {
  test::FakeRemoteTarget target;
  const auto source = [](int line) {
    return Source{std::make_shared<const std::string>("rig.toml"), line, 1};
  };
  const MidiOutMap map{{{.name = "hat", .at = source(3)},
                        {.name = "strenght", .at = source(4), .kind = Kind::Controller},
                        {.name = "hold", .at = source(5), .kind = Kind::Clock},
                        {.name = "fixed", .at = source(6), .kind = Kind::Clock}},
                       [](auto) {}};
  const auto errors = map.check(*target.description());
  REQUIRE(errors.size() == 3);
  CHECK(errors[0].where == "rig.toml:3:1");
  CHECK(errors[0].what == "the instrument has no event 'hat'");
  CHECK(errors[1].remedy.find("strength") != std::string::npos);
  CHECK(errors[2].code == Errc::UnitMismatch);
}
