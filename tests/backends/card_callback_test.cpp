#include "backends/card_callback.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <thread>

#include "engine/core/not_realtime.h"
#include "tests/support/wait_until.h"

// What every sound library calls, called by the test instead.

using namespace tactus;
using namespace std::chrono_literals;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
using Plane = std::vector<float>;

/// Output c is input c (or the sum of all inputs, where there are fewer) plus (c + 1) / 8.
class Adder final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& format) override { return format_ = format, Status{}; }
  void process(const BlockIo& io) noexcept override {
    const NotRealtime allocates;
    lengths.push_back(io.frames);
    for (int c = 0; c < format_.out_channels; ++c)
      for (int n = 0; n < io.frames; ++n)
        io.out[c][n] = (c < format_.in_channels ? io.in[c][n] : 0.0) + 0.125 * (c + 1);
  }
  std::vector<int> lengths;

 private:
  StreamFormat format_;
};

/// A callback on a device of some planes, behind guards that let everything through.
struct Card {
  Card(int inputs, int outputs, int max_frames, StreamRequest request = {},
       GuardedChannel guard = {DriveGuard::Kind::Audio, DriveLimits{}}, int periods = 0)
      : guarded(adder, std::vector<GuardedChannel>(static_cast<std::size_t>(outputs), guard)) {
    StreamGranted granted;
    granted.format = {48_kHz, inputs, outputs, max_frames};
    granted.block_frames = max_frames;
    granted.periods = periods;
    REQUIRE(guarded.prepare(granted.format));
    guarded.disable_sensor_watch();
    guarded.skip_soft_start();
    callback = std::make_unique<CardCallback>(guarded, request, granted);
  }
  /// One block; the planes that went out, which held 9 before.
  std::vector<Plane> block(const std::vector<Plane>& in, int outputs, int frames) {
    std::vector<const float*> in_planes;
    for (const auto& plane : in) in_planes.push_back(plane.empty() ? nullptr : plane.data());
    std::vector<Plane> out(static_cast<std::size_t>(outputs), Plane(static_cast<std::size_t>(frames), 9.0f));
    std::vector<float*> out_planes;
    for (auto& plane : out) out_planes.push_back(plane.data());
    callback->block(in.empty() ? nullptr : in_planes.data(), out_planes.data(), outputs, frames);
    return out;
  }

  Adder adder;
  Guarded guarded;
  std::unique_ptr<CardCallback> callback;
};

Plane plane(int frames, double value) {
  return Plane(static_cast<std::size_t>(frames), static_cast<float>(value));
}

}  // namespace

TEST_CASE("card callback: gives zeros and leaves the processor alone until it plays", "[backends]") {
  Card card{1, 1, 16};
  CHECK(card.block({plane(8, 0.5)}, 2, 8) == std::vector<Plane>{plane(8, 0), plane(8, 0)});
  CHECK(card.adder.lengths.empty());
  CHECK(card.callback->health() == Health{});
  card.callback->play();
  CHECK(card.block({plane(8, 0.5)}, 2, 8) == std::vector<Plane>{plane(8, 0.625), plane(8, 0)});
}

TEST_CASE("card callback: what begins again at zero rises from there as fast as the slew limit, no faster",
          "[backends]") {
  DriveLimits limits;
  limits.slew_per_second = 480.0;  // 0.01 a frame
  Card card{1, 1, 1, {}, {DriveGuard::Kind::Drive, limits}};
  card.callback->play();
  const auto next = [&] { return static_cast<double>(card.block({plane(1, 0.2)}, 1, 1)[0][0]); };
  for (int n = 0; n < 48000; ++n) next();
  REQUIRE(next() == Approx(0.325).epsilon(1e-6));
  card.callback->restart_from_zero();
  double before = 0.0;
  for (int n = 0; n < 48000; ++n) {
    const double now = next();
    REQUIRE(now - before <= 0.01 + 1e-7);  // samples of the card are floats
    before = now;
  }
  CHECK(before == Approx(0.325).epsilon(1e-6));
}

TEST_CASE("card callback: channels go where the maps say, and other outputs are silent", "[backends]") {
  StreamRequest request;
  request.in_map = {4, 1};
  request.out_map = {1, 4};
  Card card{2, 2, 16, request};
  card.callback->play();
  std::vector<Plane> in;
  for (int c = 0; c < 5; ++c) in.push_back(plane(4, 0.03125 * c));
  const auto out = card.block(in, 6, 4);
  CHECK(out[1] == plane(4, 4 * 0.03125 + 0.125));
  CHECK(out[4] == plane(4, 1 * 0.03125 + 0.25));
  for (const int c : {0, 2, 3, 5}) CHECK(out[static_cast<std::size_t>(c)] == plane(4, 0));
}

TEST_CASE("card callback: a block that is longer than promised is cut, and loses nothing", "[backends]") {
  Card card{1, 1, 4};
  card.callback->play();
  Plane in;
  for (int n = 0; n < 10; ++n) in.push_back(0.01f * static_cast<float>(n));
  const auto out = card.block({in}, 1, 10);
  CHECK(card.adder.lengths == std::vector<int>{4, 4, 2});
  for (std::size_t n = 0; n < 10; ++n) CHECK(out[0][n] == Approx(0.125 + 0.01 * static_cast<double>(n)));
  CHECK(card.callback->health().seconds == 0.0);
  card.block({in}, 1, 3);
  const auto health = card.callback->health();
  CHECK(health.seconds > 0.0);
  CHECK(health.blocks == 2);
  CHECK(health.frames == 13);
  CHECK(health.shortest_block == 3);
  CHECK(health.longest_block == 10);
}

TEST_CASE("card callback: an empty block, missing planes and no inputs at all are silence", "[backends]") {
  Card card{2, 1, 16};
  card.callback->play();
  card.block({}, 1, 0);
  CHECK(card.adder.lengths.empty());
  CHECK(card.block({}, 1, 4) == std::vector<Plane>{plane(4, 0.125)});
  CHECK(card.block({{}, plane(4, 0.3)}, 1, 4) == std::vector<Plane>{plane(4, 0.125)});
}

TEST_CASE("card callback: input that is no number becomes 0 and is counted", "[backends]") {
  Card card{1, 1, 16};
  card.callback->play();
  const Plane in{0.5f, kNan, -std::numeric_limits<float>::infinity(), 0.25f};
  const auto out = card.block({in}, 1, 4);
  CHECK(out[0] == Plane{0.625f, 0.125f, 0.125f, 0.375f});
  CHECK(card.callback->health().bad_input == 2);
}

TEST_CASE("card callback: the last block is zeros without the processor, and silence follows", "[backends]") {
  Card card{1, 1, 16};
  card.callback->play();
  card.block({plane(8, 0.5)}, 1, 8);
  std::vector<Plane> played_back;
  std::atomic<bool> done{false};
  std::thread library{[&] {
    while (!done) played_back.push_back(card.block({plane(8, 0.5)}, 1, 8)[0]);
  }};
  const bool finished = card.callback->finish();
  const auto played = card.adder.lengths.size();
  done = true;
  library.join();
  CHECK(finished);
  CHECK_FALSE(card.callback->playing());
  CHECK(card.adder.lengths.size() == played);
  REQUIRE_FALSE(played_back.empty());
  const auto silent = [](const Plane& block) { return block == plane(8, 0); };
  // The processor's first block was not the library's.
  CHECK(
      std::all_of(played_back.begin() + static_cast<std::ptrdiff_t>(played) - 1, played_back.end(), silent));
  CHECK(card.callback->health().blocks == static_cast<std::int64_t>(played));
}

TEST_CASE("card callback: whoever waits for the last block of a dead device is notified that none came",
          "[backends]") {
  Card card{1, 1, 16};
  CHECK(card.callback->finish());  // nothing played, so nothing must end
  card.callback->play();
  CHECK_FALSE(card.callback->finish());
  card.callback->abandon();
  CHECK(card.block({plane(8, 0.5)}, 1, 8) == std::vector<Plane>{plane(8, 0)});
  CHECK(card.adder.lengths.empty());
}

TEST_CASE("card callback: a stop, and a stall that is over, come to zero within the slew limit",
          "[backends]") {
  const bool stall = GENERATE(false, true);
  // 0.125 at 100 full scales a second: 60 frames.
  Card card{1, 1, 16, {}, {DriveGuard::Kind::Drive, {.slew_per_second = 100.0}}};
  card.callback->play();
  Plane played;
  const auto play = [&](int blocks) {
    for (int block = 0; block < blocks; ++block) {
      const auto out = card.block({plane(16, 0.0)}, 1, 16);
      played.insert(played.end(), out[0].begin(), out[0].end());
    }
  };
  play(10);
  REQUIRE(played.back() == 0.125f);
  if (stall) {
    REQUIRE(test::wait_until([&] { return card.callback->stalled(); }));
    play(10);
  } else {
    std::atomic<bool> done{false};
    std::thread library{[&] {
      while (!done) play(1);
    }};
    CHECK(card.callback->finish());
    done = true;
    library.join();
  }
  for (std::size_t n = 1; n < played.size(); ++n) CHECK(std::abs(played[n] - played[n - 1]) < 100.1f / 48000);
  CHECK(std::count(played.begin() + 160, played.end(), 0.0f) > 0);
}

TEST_CASE("card callback: an abandoned one never touches the processor again", "[backends]") {
  Card card{1, 1, 16};
  card.callback->play();
  std::atomic<bool> done{false};
  std::thread library{[&] {
    while (!done) card.block({plane(8, 0.5)}, 1, 8);
  }};
  card.callback->abandon();
  const auto played = card.adder.lengths.size();  // a race, if the processor still ran: the sanitizer tells
  done = true;
  library.join();
  CHECK(card.adder.lengths.size() == played);
}

TEST_CASE("card callback: the driver's buffer is full of zeros before the library closes it", "[backends]") {
  Card card{1, 1, 16};
  card.callback->play();
  card.callback->abandon();
  std::atomic<bool> done{false};
  std::atomic<int> blocks{0}, sounding{0};
  std::thread library{[&] {
    while (!done) {
      sounding += card.block({plane(8, 0.5)}, 1, 8)[0] != plane(8, 0);
      ++blocks;
    }
  }};
  card.callback->fill_with_zeros(1000);
  CHECK(blocks >= 1000 / 8 - 1);
  done = true;
  library.join();
  CHECK(sounding == 0);
  card.callback->fill_with_zeros(1'000'000'000);  // ends by itself: no block comes any more
}

TEST_CASE("card callback: gaps are counted by cause, and lost frames once", "[backends]") {
  Card card{1, 1, 16};
  card.callback->play();
  for (int n = 0; n < 3; ++n) card.callback->gap(Gap::Input);
  card.callback->gap(Gap::Output);
  card.callback->gap(Gap::Server);
  card.callback->lost(512);
  const auto health = card.callback->health();
  CHECK(health.gaps == std::array<std::int64_t, kGaps>{3, 1, 1, 0});
  CHECK(health.xruns == 5);
  CHECK(health.lost_frames == 512);
}

// In a gap the mass is pushed by something else: after a counted one by so much at most, after another
// anywhere.
TEST_CASE("card callback: after a gap it is unknown where the mass is", "[backends]") {
  const ExcursionLimits travel{.metres = 5e-3, .metres_at_full_scale = 10e-3, .resonance = 30_Hz, .q = 0.5};
  Card card{1, 1, 64, {}, {DriveGuard::Kind::Drive, {.ceiling = 0.5, .excursion = travel}}};
  card.callback->play();
  const auto displacement_after = [&](auto gap) {
    gap(*card.callback);
    card.guarded.arm(true);
    (void)card.block({plane(1, 0)}, 1, 1);
    return card.guarded.excursion(0);
  };
  const double frame = 2 * kPi * 30.0 / 48'000.0;
  CHECK(displacement_after([](CardCallback&) {}) == 0.0);
  CHECK(displacement_after([](CardCallback& callback) {
          callback.gap(Gap::Server, CardCallback::GapLength::Counted);
        }) == 0.0);
  CHECK(displacement_after([](CardCallback& callback) { callback.lost(64); }) ==
        Approx(64 * frame * (1 + 1 / 0.5 + 2 * 0.5)).epsilon(1e-9));
  CHECK(displacement_after([](CardCallback& callback) { callback.gap(Gap::Output); }) == Approx(2 + 2 * 0.5));
}

TEST_CASE("card callback: while frames do not run at their rate zeros go out and no time passes",
          "[backends]") {
  Card card{1, 1, 16};
  card.callback->play();
  card.block({plane(16, 0.5)}, 1, 16);
  const auto frame = card.guarded.frame();
  card.callback->suspend(true);
  CHECK(card.block({plane(16, 0.5)}, 1, 16) == std::vector<Plane>{plane(16, 0)});  // from Guarded::finish
  const auto before = card.callback->health();
  for (int n = 0; n < 1000; ++n)
    REQUIRE(card.block({plane(16, 0.5)}, 1, 16) == std::vector<Plane>{plane(16, 0)});
  CHECK(card.guarded.frame() == frame);  // and with it heat, fades and soft starts
  CHECK(card.callback->health() == before);
  CHECK_FALSE(card.callback->stalled());
  card.callback->suspend(false);
  CHECK(card.block({plane(16, 0.5)}, 1, 16) == std::vector<Plane>{plane(16, 0.625)});
  CHECK(card.guarded.frame() == frame + 16);
}

TEST_CASE("card callback: a dead man's switch does not expire while frames do not run at their rate",
          "[backends]") {
  Card card{1, 1, 16};
  DeadMansSwitch dead_man;
  card.guarded.set_dead_mans_switch(&dead_man);
  REQUIRE(card.guarded.prepare({48_kHz, 1, 1, 16}));
  card.guarded.skip_soft_start();
  card.callback->play();
  card.callback->suspend(true);
  for (int n = 0; n < 3000; ++n) card.block({plane(16, 0.5)}, 1, 16);  // one second of frames
  card.callback->suspend(false);
  CHECK(card.block({plane(16, 0.5)}, 1, 16) == std::vector<Plane>{plane(16, 0.625)});
  GuardEvent event;
  CHECK_FALSE(card.guarded.take_event(event));
  // Half a second from its first frame on, one block of which was before.
  while (card.guarded.frame() < 24'000) card.block({plane(16, 0.5)}, 1, 16);
  CHECK_FALSE(card.guarded.take_event(event));
  card.block({plane(16, 0.5)}, 1, 16);
  REQUIRE(card.guarded.take_event(event));
  CHECK(event.kind == GuardEvent::Kind::DeadMan);
}

TEST_CASE("card callback: where a library does not report it, frames ahead of the clock are noticed",
          "[backends]") {
  Card card{1, 1, 480};
  card.callback->play();
  const auto zeros = std::vector<Plane>{plane(480, 0)};
  // Each block stands for 10 ms, and takes some microseconds: noticed in the second half a second of the
  // clock.
  REQUIRE(test::wait_until([&] { return card.block({plane(480, 0.5)}, 1, 480) == zeros; }));
  const auto frame = card.guarded.frame();
  for (int n = 0; n < 100; ++n) REQUIRE(card.block({plane(480, 0.5)}, 1, 480) == zeros);
  CHECK(card.guarded.frame() == frame);
}

TEST_CASE(
    "card callback: outputs of a lost device come to zero within the slew limit while blocks still come",
    "[backends]") {
  // From 0.625 at 480/s: 0.01 a frame, 62 frames and a half.
  GuardedChannel slow{DriveGuard::Kind::Drive, DriveLimits{}};
  slow.limits.slew_per_second = 480.0;
  Card card{1, 1, 16, {}, slow};
  card.callback->play();
  while (card.block({plane(16, 0.5)}, 1, 16)[0].back() < 0.6249f) {
  }
  std::atomic<bool> done{false};
  std::vector<float> played;
  std::thread library{[&] {
    while (!done) {
      const auto block = card.block({}, 1, 16)[0];
      played.insert(played.end(), block.begin(), block.end());
    }
  }};
  const bool finished = card.callback->finish(true);
  done = true;
  library.join();
  CHECK(finished);
  CHECK(played.back() == 0.0f);
  float steepest = 0.0f;
  for (std::size_t n = 1; n < played.size(); ++n)
    steepest = std::max(steepest, std::abs(played[n] - played[n - 1]));
  CHECK(steepest == Approx(0.01).margin(1e-6));
}

TEST_CASE("card callback: without blocks nothing waits for the outputs of a lost device", "[backends]") {
  Card card{1, 1, 16};
  card.callback->play();
  card.block({plane(16, 0.5)}, 1, 16);
  CHECK_FALSE(card.callback->finish(true));
}

TEST_CASE("card callback: a suspended stream can be stopped", "[backends]") {
  Card card{0, 1, 16};
  card.callback->play();
  card.callback->suspend(true);
  std::atomic<bool> done{false};
  std::thread library{[&] {
    while (!done) card.block({}, 1, 16);
  }};
  CHECK(card.callback->finish());
  done = true;
  library.join();
}

TEST_CASE("card callback: a block that comes later than the driver's buffer lasts is a gap", "[backends]") {
  constexpr int kBlock = 48;  // two of them last 2 ms
  for (const int periods : {0, 2, 1'000'000}) {
    CAPTURE(periods);
    Card card{1, 1, kBlock, {}, {DriveGuard::Kind::Audio, DriveLimits{}}, periods};
    card.callback->play();
    card.block({plane(kBlock, 0)}, 1, kBlock);
    std::this_thread::sleep_for(3ms);  // part of what is tested
    card.block({plane(kBlock, 0)}, 1, kBlock);
    CHECK(card.callback->health().xruns == (periods == 2 ? 1 : 0));
    std::this_thread::sleep_for(3ms);
    card.callback->gaps(false, false, true);  // the library reports it
    card.block({plane(kBlock, 0)}, 1, kBlock);
    CHECK(card.callback->health().xruns == (periods == 2 ? 2 : 1));
  }
}
