#include "engine/core/guarded.h"

#include <catch2/catch.hpp>
#include <vector>

using namespace tactus;
using Kind = JournalEntry::Kind;

namespace {

/// Puts `level` on every output and remembers the blocks it was given.
class Level final : public BlockProcessor {
 public:
  explicit Level(double level) : level_(level) {}
  Status prepare(const StreamFormat& format) override {
    channels_ = format.out_channels;
    blocks.reserve(1000);
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    blocks.push_back(io.frames);
    for (int c = 0; c < channels_; ++c)
      for (int n = 0; n < io.frames; ++n) io.out[c][n] = level_;
  }
  std::vector<int> blocks;

 private:
  double level_;
  int channels_ = 0;
};

/// Runs `guarded` for `frames` frames in one call and returns the outputs.
std::vector<std::vector<double>> play(Guarded& guarded, int channels, int frames) {
  std::vector<std::vector<double>> out(static_cast<std::size_t>(channels),
                                       std::vector<double>(static_cast<std::size_t>(frames), -99.0));
  std::vector<double*> pointers;
  for (auto& channel : out) pointers.push_back(channel.data());
  guarded.process({nullptr, pointers.data(), frames});
  return out;
}

constexpr DriveLimits kAtOnce{.soft_start = Seconds{0}, .fade_out = Seconds{0}};
const GuardedChannel kDrive{DriveGuard::Kind::Drive, kAtOnce};
const GuardedChannel kAudio{DriveGuard::Kind::Audio, kAtOnce};

}  // namespace

TEST_CASE("guarded: every output passes its guard, named or not", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {{DriveGuard::Kind::Drive, {.ceiling = 0.5}}}};
  REQUIRE(guarded.prepare({.out_channels = 2}));
  Level loud{3.0};
  Guarded unnamed{loud, {}};
  REQUIRE(unnamed.prepare({.out_channels = 1}));
  CHECK(play(guarded, 2, 8)[0] == std::vector<double>(8, 0.5));
  CHECK(play(guarded, 2, 8)[1] == std::vector<double>(8, 1.0));
  CHECK(play(unnamed, 1, 8)[0] == std::vector<double>(8, 1.0));
  CHECK(guarded.counts(0) == GuardCounts{.ceiling = 16});
  CHECK(guarded.frame() == 16);
}

TEST_CASE("guarded: arm and mute hold from their frame on, and are reported with it", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive, kAudio}, /*armed=*/false};
  REQUIRE(guarded.prepare({.out_channels = 2}));
  REQUIRE(guarded.post({3, Kind::Arm, JournalEntry::kAllChannels, 1.0}));
  REQUIRE(guarded.post({6, Kind::Mute, 0, 1.0}));
  const auto out = play(guarded, 2, 8);
  CHECK(out[0] == std::vector<double>{0, 0, 0, 1, 1, 1, 0, 0});
  CHECK(out[1] == std::vector<double>(8, 1.0));  // what is only heard needs no arming

  REQUIRE(guarded.post({JournalEntry::kNow, Kind::Mute, JournalEntry::kAllChannels, 1.0}));
  CHECK(play(guarded, 2, 4)[1] == std::vector<double>(4, 0.0));

  JournalEntry entry;
  REQUIRE(guarded.take_applied(entry));
  CHECK(entry == JournalEntry{3, Kind::Arm, JournalEntry::kAllChannels, 1.0});
  REQUIRE(guarded.take_applied(entry));
  CHECK(entry == JournalEntry{6, Kind::Mute, 0, 1.0});
  REQUIRE(guarded.take_applied(entry));
  CHECK(entry == JournalEntry{8, Kind::Mute, JournalEntry::kAllChannels, 1.0});
  CHECK_FALSE(guarded.take_applied(entry));
}

TEST_CASE("guarded: an entry for a later block waits for it", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  REQUIRE(guarded.post({10, Kind::Mute, 0, 1.0}));
  CHECK(play(guarded, 1, 8)[0] == std::vector<double>(8, 1.0));
  CHECK(play(guarded, 1, 4)[0] == std::vector<double>{1, 1, 0, 0});
}

TEST_CASE("guarded: an unmuted drive that is disarmed stays silent", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}, /*armed=*/false};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  REQUIRE(guarded.post({0, Kind::Mute, 0, 1.0}));
  REQUIRE(guarded.post({1, Kind::Mute, 0, 0.0}));
  CHECK(play(guarded, 1, 4)[0] == std::vector<double>(4, 0.0));
}

TEST_CASE("guarded: cuts a block that is longer than promised", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 1, .max_frames = 4}));
  CHECK(play(guarded, 1, 10)[0] == std::vector<double>(10, 1.0));
  CHECK(level.blocks == std::vector<int>{4, 4, 2});
}

TEST_CASE("guarded: refuses entries that are not for it, and more than it can hold", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  CHECK_FALSE(guarded.post({0, Kind::ControlChange, 0, 1.0}));
  int taken = 0;
  while (taken < 10'000 && guarded.post({0, Kind::Mute, 0, 0.0})) ++taken;
  CHECK(taken == 256);
}

TEST_CASE("guarded: prepare says what does not fit", "[core]") {
  Level level{1.0};
  Guarded many{level, {kDrive, kDrive}};
  CHECK(to_string(many.prepare({.out_channels = 1}).error()) ==
        "2 guarded channels, but the stream has 1 outputs; open the stream with more outputs");
  Guarded wrong{level, {{DriveGuard::Kind::Drive, {.ceiling = 2.0}}}};
  CHECK(wrong.prepare({.out_channels = 1}).error().code == Errc::OutOfRange);
}
