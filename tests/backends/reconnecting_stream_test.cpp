#include "backends/reconnecting_stream.h"

#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"
#include "tests/support/fake_backend.h"

// With a backend that fails on request.

using namespace tactus;
using namespace std::chrono_literals;
using test::FakeBackend;

namespace {

class Silence final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return ++prepared, Status{}; }
  void process(const BlockIo&) noexcept override {}
  int prepared = 0;
};

struct Fixture {
  Fixture() { open(); }
  void open() {
    stream = std::move(*ReconnectingStream::open(backend, {}, guarded));
    stream->on_return([this](const Return& back) { returns.push_back(back); });
    stream->on_change([this] { ++changes; });
    REQUIRE(stream->start());
  }
  /// The application's loop, 20 times a second, on clocks of its own.
  void run(std::chrono::milliseconds time) {
    for (const auto end = now + time; now < end; now += 50ms) stream->tick(now, suspended);
  }
  /// The device goes away, and is there again after this time.
  const Return& lose(
      std::chrono::milliseconds time, const std::function<void()>& change = [] {}) {
    const auto before = returns.size();
    world.there = false;
    world.state = StreamState::Lost;
    run(time);
    change();
    world.there = true;
    run(1s);
    REQUIRE(returns.size() == before + 1);
    return returns.back();
  }
  std::vector<std::string> events() {
    std::vector<std::string> all;
    while (auto event = stream->take_event()) all.push_back(*event);
    return all;
  }

  test::FakeWorld world;
  FakeBackend backend{world};
  Silence silence;
  Guarded guarded{silence, {}};
  std::unique_ptr<ReconnectingStream> stream;
  ReconnectingStream::Clock::time_point now;
  std::chrono::nanoseconds suspended{};
  std::vector<Return> returns;
  int changes = 0;
};

using Events = std::vector<std::string>;

}  // namespace

TEST_CASE("reconnecting stream: a device that comes back is opened again, and each step is reported",
          "[backends]") {
  Fixture f;
  f.run(1s);
  CHECK(f.world.tried == 1);
  f.world.there = false;
  f.world.state = StreamState::Lost;
  f.run(1s);
  CHECK(f.stream->state() == StreamState::Lost);
  CHECK(f.world.destroyed == 1);
  CHECK(f.world.tried == 1 + 5);  // each 200 ms
  f.world.there = true;
  f.run(250ms);
  CHECK(f.stream->state() == StreamState::Running);
  CHECK(f.stream->returns() == 1);
  CHECK(f.silence.prepared == 2);
  CHECK(f.events() == Events{"'fake:one': disconnected; outputs are silent until it reconnects",
                             "'fake:one': waiting for it: there is no device 'fake:one'",
                             "'fake:one': reconnected after 1.1 s"});
}

TEST_CASE("kept stream: never another device than the one that was opened", "[backends]") {
  Fixture f;
  f.world.default_device = "fake:two";
  f.world.state = StreamState::Lost;
  f.run(500ms);
  CHECK(f.world.opened == Events{"fake:one", "fake:one"});
}

TEST_CASE("kept stream: a device that comes back with another block tells it", "[backends]") {
  Fixture f;
  f.world.block = 128;
  f.world.state = StreamState::Lost;
  f.run(500ms);
  CHECK(f.stream->granted().block_frames == 128);
  CHECK(test::names_in(f.events().back()) == "'fake:one' 128 64");
}

TEST_CASE("kept stream: a device that opens but does not start is tried again", "[backends]") {
  Fixture f;
  f.world.state = StreamState::Lost;
  f.world.starts = false;
  f.run(1s);
  CHECK(f.stream->state() == StreamState::Lost);
  f.world.starts = true;
  f.run(250ms);
  CHECK(f.stream->state() == StreamState::Running);
  CHECK(f.events().size() == 3);
}

TEST_CASE("reconnecting stream: what cannot come back in this process is reported once and left alone",
          "[backends]") {
  Fixture f;
  f.world.comes_back = false;
  f.open();
  const int tried = f.world.tried, destroyed = f.world.destroyed;
  f.world.state = StreamState::Lost;
  f.run(1s);
  CHECK(f.world.tried == tried);
  CHECK(f.world.destroyed == destroyed);
  CHECK(f.stream->state() == StreamState::Lost);
  CHECK(f.events() == Events{"'fake:one': disconnected; restart the program to reopen it"});
}

TEST_CASE("reconnecting stream: the same device, back within 10 s, is the same", "[backends]") {
  Fixture f;
  f.world.output = {"1-2:1.0 serial 42", 2, {"card:playback_1"}, false};
  f.open();
  CHECK(f.lose(9s).same());
  CHECK(f.returns.back().away.count() == Approx(9.0).margin(0.3));
  const auto back = f.lose(11s);
  CHECK_FALSE(back.same());
  CHECK(test::names_in(back.differences.at(0)) == "10");
  CHECK(test::names_in(f.events().back()) == "'fake:one' 10");
}

TEST_CASE("reconnecting stream: a device was away from when its stream last ran, stalled or unseen before",
          "[backends]") {
  Fixture f;
  f.world.output = {"1-2:1.0 serial 42", 2, {"card:playback_1"}, false};
  f.open();
  f.run(1s);
  f.world.state = StreamState::Stalled;
  f.run(6s);
  const auto stalled = f.lose(6s);
  CHECK_FALSE(stalled.same());
  CHECK(stalled.away.count() == Approx(12.0).margin(0.3));
  f.run(1s);
  f.now += 6s;  // the program was stopped
  const auto unseen = f.lose(6s);
  CHECK_FALSE(unseen.same());
  CHECK(unseen.away.count() == Approx(12.0).margin(0.3));
  f.run(1s);
  CHECK(f.lose(6s).same());
}

TEST_CASE("reconnecting stream: each thing in which a device differs is reported before blocks flow",
          "[backends]") {
  Fixture f;
  f.world.output = {"1-2:1.0", 2, {"card:playback_1", "card:playback_2"}, false};
  f.open();
  const auto differs = [&](const std::function<void()>& change) {
    std::string names;
    for (const auto& difference : f.lose(1s, change).differences)
      names += (names.empty() ? "" : "; ") + test::names_in(difference);
    return names;
  };
  CHECK(differs([&] { f.world.output.hardware = "1-3:1.0"; }) == "'1-3:1.0' '1-2:1.0'");
  CHECK(differs([&] { f.world.output.channels = 8; }) == "8 2");
  CHECK(differs([&] { std::swap(f.world.output.ports[0], f.world.output.ports[1]); }) ==
        "1 'card:playback_2' 'card:playback_1'; 2 'card:playback_1' 'card:playback_2'");
  CHECK(differs([&] { f.world.block = 128; }) == "128 64");
  CHECK(differs([&] { f.world.periods = 3; }) == "3 2");
  CHECK(differs([] {}) == "");
  f.world.output.ambiguous = true;
  CHECK_FALSE(f.lose(1s).same());
  CHECK_FALSE(f.lose(1s).same());  // and again: it may be another one each time
}

TEST_CASE("reconnecting stream: a difference is not forgotten when the device does not start at first",
          "[backends]") {
  Fixture f;
  f.world.starts = false;
  f.world.block = 128;
  f.world.state = StreamState::Lost;
  f.run(1s);
  CHECK(f.returns.empty());
  f.world.starts = true;
  f.run(1s);
  REQUIRE(f.returns.size() == 1);
  CHECK(test::names_in(f.returns[0].differences.at(0)) == "128 64");
}

TEST_CASE("reconnecting stream: a device that returns is looked for on its hardware and by its ports",
          "[backends]") {
  Fixture f;
  f.world.output = {"1-2:1.0", 2, {"card:playback_2"}, false};
  f.open();
  CHECK_FALSE(f.world.requests.back().previous);
  f.lose(1s);
  const auto& previous = f.world.requests.back().previous;
  REQUIRE(previous);
  CHECK(previous->output == f.world.output);
}

TEST_CASE("reconnecting stream: a suspension is a difference, whether it plays or is away", "[backends]") {
  Fixture f;
  f.run(1s);
  CHECK(f.changes == 0);
  f.suspended += 63s;
  f.run(1s);
  CHECK(f.changes == 1);
  CHECK(test::names_in(f.events().back()) == "'fake:one' 63.0");
  const auto& back = f.lose(1s, [&] { f.suspended += 5s; });
  CHECK(f.changes == 1);
  CHECK(back.differences.size() == 1);
  CHECK(back.away.count() > 5.9);
  CHECK(f.lose(1s).same());
  CHECK(time_suspended().count() >= 0);
}

TEST_CASE("reconnecting stream: another block size while it plays is reported once", "[backends]") {
  Fixture f;
  f.world.block_now = 256;
  f.run(1s);
  CHECK(f.changes == 1);
  CHECK(f.events().size() == 1);
  CHECK(f.stream->granted().block_frames == 256);
  f.world.block = 256;
  CHECK(f.lose(1s).same());
}

TEST_CASE("kept stream: what was stopped stays away, until it is started", "[backends]") {
  Fixture f;
  f.world.there = false;
  f.world.state = StreamState::Lost;
  f.run(500ms);
  CHECK(f.stream->stop());
  f.world.there = true;
  f.run(1s);
  CHECK(f.world.opened.size() == 1);
  CHECK(f.stream->start());
  f.run(250ms);
  CHECK(f.stream->state() == StreamState::Running);
}

TEST_CASE("kept stream: health counts over all openings", "[backends]") {
  Fixture f;
  Health first;
  first.blocks = 3;
  first.frames = 300;
  first.seconds = 0.25;
  first.xruns = first.gaps[2] = 2;
  first.lost_frames = 7;
  first.shortest_block = 50;
  first.longest_block = 200;
  first.mean_load = 0.2;
  first.peak_load = 0.9;
  first.median_load = 0.15;
  f.world.health = first;
  f.world.there = false;
  f.world.state = StreamState::Lost;
  f.run(500ms);
  CHECK(f.stream->health() == first);
  f.world.there = true;
  f.run(500ms);
  CHECK(f.stream->health() == first);
  Health second;
  second.blocks = 1;
  second.frames = 100;
  second.seconds = 0.5;
  second.xruns = second.gaps[0] = 1;
  second.shortest_block = second.longest_block = 100;
  second.mean_load = 0.6;
  second.peak_load = 0.6;
  second.median_load = 0.6;
  f.world.health = second;
  const auto all = f.stream->health();
  CHECK(all.blocks == 4);
  CHECK(all.frames == 400);
  CHECK(all.seconds == 0.75);
  CHECK(all.xruns == 3);
  CHECK(all.gaps == std::array<std::int64_t, kGaps>{1, 0, 2, 0});
  CHECK(all.lost_frames == 7);
  CHECK(all.shortest_block == 50);
  CHECK(all.longest_block == 200);
  CHECK(all.mean_load == Approx(0.3));  // (3 * 0.2 + 0.6) / 4
  CHECK(all.peak_load == 0.9);
  CHECK(all.median_load == 0.6);
}

TEST_CASE("reconnecting stream: a stall is reported when it begins and when it ends", "[backends]") {
  Fixture f;
  f.world.state = StreamState::Stalled;
  f.run(700ms);
  f.world.state = StreamState::Running;
  f.run(500ms);
  CHECK(f.world.opened.size() == 1);
  CHECK(f.events() == Events{"'fake:one': does not respond", "'fake:one': responds again after 0.7 s"});
}

TEST_CASE("kept stream: what a stream has to say is passed on", "[backends]") {
  Fixture f;
  f.world.notes = {"a cable is loose", "it is in again"};
  f.run(50ms);
  CHECK(f.events() == Events{"'fake:one': a cable is loose", "'fake:one': it is in again"});
}

TEST_CASE("kept stream: an error of the first opening is the caller's", "[backends]") {
  test::FakeWorld world;
  world.there = false;
  FakeBackend backend{world};
  Silence silence;
  Guarded guarded{silence, {}};
  StreamRequest request;
  request.device = "fake:one";
  const auto stream = ReconnectingStream::open(backend, request, guarded);
  REQUIRE_FALSE(stream);
  CHECK(test::summary(stream) == "UnknownName 'fake:one'");
}

TEST_CASE("reconnecting stream: a device that does not respond for more than 10 s is not as it was",
          "[backends]") {
  Fixture f;
  f.run(1s);
  f.world.state = StreamState::Stalled;
  f.run(9900ms);
  CHECK(f.changes == 0);
  f.run(20s);
  CHECK(f.changes == 1);
  f.world.state = StreamState::Running;
  f.run(1s);
  f.world.state = StreamState::Stalled;
  f.run(9900ms);
  CHECK(f.changes == 1);
  CHECK(f.events()[1] == "'fake:one': does not respond for more than 10 s");
}

TEST_CASE("reconnecting stream: the program may be stopped for a part of that time", "[backends]") {
  SECTION("when it begins") {
    Fixture f;
    f.run(1s);
    f.world.state = StreamState::Stalled;
    f.now += 4400ms;
    f.run(5500ms);
    CHECK(f.changes == 0);
    f.run(300ms);
    CHECK(f.changes == 1);
  }
  SECTION("until it ends") {
    Fixture f;
    f.run(1s);
    f.world.state = StreamState::Stalled;
    f.run(6s);
    f.now += 4400ms;
    f.world.state = StreamState::Running;
    f.run(50ms);
    CHECK(f.changes == 1);
    CHECK(f.events().back() == "'fake:one': responds again after 10.4 s");
  }
}

TEST_CASE("reconnecting stream: a restart prepares the processor again, on the same device", "[backends]") {
  Fixture f;
  f.world.output = {"", 2, {"card:playback_1"}, false};  // unknown hardware: no difference within a moment
  f.open();
  f.run(500ms);
  const int prepared = f.silence.prepared;
  f.world.default_device = "fake:two";
  REQUIRE(f.stream->restart(f.now));
  CHECK(f.stream->state() == StreamState::Running);
  CHECK(f.silence.prepared == prepared + 1);
  CHECK(f.world.opened.back() == "fake:one");
  REQUIRE(f.returns.size() == 1);
  CHECK(f.returns[0].same());
  f.world.output.ports = {"card:playback_2"};
  REQUIRE(f.stream->restart(f.now));
  CHECK_FALSE(f.returns.back().same());
}

TEST_CASE("reconnecting stream: a device that is gone at a restart is looked for", "[backends]") {
  Fixture f;
  f.run(500ms);
  f.world.there = false;
  CHECK_FALSE(f.stream->restart(f.now));
  CHECK(f.stream->state() == StreamState::Lost);
  CHECK(f.returns.empty());
  f.world.there = true;
  f.run(250ms);
  CHECK(f.stream->state() == StreamState::Running);
  CHECK(f.returns.size() == 1);
}
