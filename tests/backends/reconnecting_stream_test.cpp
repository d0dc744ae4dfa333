#include "backends/reconnecting_stream.h"

#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"

// With a backend that fails on request.

using namespace tactus;
using namespace std::chrono_literals;

namespace {

/// What the test decides and what the backend did.
struct World {
  StreamState state = StreamState::Stopped;
  bool there = true, starts = true, comes_back = true;
  Health health;
  std::vector<std::string> notes;
  std::string default_device = "fake:one";
  std::vector<std::string> opened;
  int block = 64, destroyed = 0, tried = 0;
};

class FakeStream final : public Stream {
 public:
  FakeStream(World& world, StreamGranted granted) : world_(world), granted_(std::move(granted)) {}
  ~FakeStream() override { ++world_.destroyed; }
  const StreamGranted& granted() const override { return granted_; }
  Status start() override {
    if (!world_.starts) return fail(Errc::Device, "", "it does not start");
    world_.state = StreamState::Running;
    return {};
  }
  Status stop() override { return world_.state = StreamState::Stopped, Status{}; }
  StreamState state() const override { return world_.state; }
  Health health() const override { return world_.health; }
  std::string take_note() override {
    if (world_.notes.empty()) return {};
    auto note = world_.notes.front();
    world_.notes.erase(world_.notes.begin());
    return note;
  }

 private:
  World& world_;
  StreamGranted granted_;
};

class FakeBackend final : public Backend {
 public:
  explicit FakeBackend(World& world) : world_(world) {}
  std::string name() const override { return "fake"; }
  Result<std::vector<Device>> devices() override { return std::vector<Device>{}; }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override {
    ++world_.tried;
    if (!world_.there) return fail(Errc::UnknownName, "", "there is no device '" + request.device + "'");
    StreamGranted granted;
    granted.device = request.device.empty() ? world_.default_device : request.device;
    granted.format = {request.sample_rate.value_or(48_kHz), 0, 1, 64};
    granted.block_frames = world_.block;
    granted.comes_back = world_.comes_back;
    if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
    world_.opened.push_back(granted.device);
    world_.state = StreamState::Stopped;
    world_.health = {};
    return std::make_unique<FakeStream>(world_, granted);
  }

 private:
  World& world_;
};

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
    REQUIRE(stream->start());
  }
  /// The application's loop, 20 times a second, on a clock of its own.
  void run(std::chrono::milliseconds time) {
    for (const auto end = now + time; now < end; now += 50ms) stream->tick(now);
  }
  std::vector<std::string> events() {
    std::vector<std::string> all;
    while (auto event = stream->take_event()) all.push_back(*event);
    return all;
  }

  World world;
  FakeBackend backend{world};
  Silence silence;
  Guarded guarded{silence, {}};
  std::unique_ptr<ReconnectingStream> stream;
  ReconnectingStream::Clock::time_point now;
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
  World world;
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
