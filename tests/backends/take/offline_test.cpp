#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "backends/health.h"
#include "backends/take/replay.h"

using namespace tactus;

namespace {

/// y = half of x plus half of the output before: it has a state, so that a lost or doubled frame shows.
class Smooth final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& format) override {
    format_ = format;
    last_.assign(static_cast<std::size_t>(format.out_channels), 0.0);
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    for (int c = 0; c < format_.out_channels; ++c) {
      double& last = last_[static_cast<std::size_t>(c)];
      for (int n = 0; n < io.frames; ++n) {
        last = 0.5 * last + (c < format_.in_channels ? 0.5 * io.in[c][n] : 0.0);
        io.out[c][n] = last;
      }
    }
  }
  const StreamFormat& format() const { return format_; }

 private:
  StreamFormat format_;
  std::vector<double> last_;
};

/// Guards that change nothing below full scale.
std::vector<GuardedChannel> no_limits(std::size_t channels) { return std::vector<GuardedChannel>(channels); }

Samples ramp(std::size_t channels, std::size_t frames) {
  Samples samples{Hertz{96e3}, std::vector<std::vector<double>>(channels, std::vector<double>(frames))};
  for (auto& channel : samples.channels)
    for (std::size_t n = 0; n < frames; ++n) channel[n] = static_cast<double>(n % 97) / 97.0 - 0.5;
  return samples;
}

Result<Samples> render(Guarded& guarded, const Samples& input, std::size_t channels,
                       const std::vector<int>& blocks = {256}) {
  Samples output{input.sample_rate, std::vector<std::vector<double>>(channels)};
  const auto sink = [&](const double* const* out, int frames) -> Status {
    for (std::size_t c = 0; c < channels; ++c)
      output.channels[c].insert(output.channels[c].end(), out[c], out[c] + frames);
    return {};
  };
  if (auto status = run_offline(guarded, offline_input(input), static_cast<int>(channels), blocks, sink);
      !status)
    return tl::unexpected(status.error());
  return output;
}

}  // namespace

TEST_CASE("offline: blocks of any size, also changing ones, give the same output", "[backends]") {
  const auto input = ramp(2, 1000);
  Smooth reference_inner;
  Guarded reference{reference_inner, no_limits(3)};
  const auto expected = render(reference, input, 3, {1000});
  REQUIRE(expected);
  REQUIRE(expected->frames() == 1000);
  CHECK(expected->sample_rate == Hertz{96e3});
  // y[1] = x[0]/4 + x[1]/2
  CHECK(expected->channels[1][1] == 0.25 * input.channels[1][0] + 0.5 * input.channels[1][1]);
  CHECK(expected->channels[2] == std::vector<double>(1000, 0.0));

  const auto blocks = GENERATE(std::vector<int>{1}, std::vector<int>{64}, std::vector<int>{7, 256, 1, 13},
                               std::vector<int>{4096});
  Smooth inner;
  Guarded guarded{inner, no_limits(3)};
  const auto output = render(guarded, input, 3, blocks);
  REQUIRE(output);
  CHECK((output->channels == expected->channels));
}

TEST_CASE("offline: the processor gets the rate, the channels and the longest block", "[backends]") {
  Smooth inner;
  Guarded guarded{inner, {}};
  std::vector<int> blocks;
  const auto sink = [&](const double* const*, int frames) { return blocks.push_back(frames), Status{}; };
  const Samples silence{Hertz{22050}, {std::vector<double>(90)}};
  REQUIRE(run_offline(guarded, offline_input(silence), 5, {10, 30, 20}, sink));
  CHECK(inner.format().sample_rate == Hertz{22050});
  CHECK(inner.format().in_channels == 1);
  CHECK(inner.format().out_channels == 5);
  CHECK(inner.format().max_frames == 30);
  CHECK(blocks == std::vector<int>{10, 30, 20, 10, 20});
  CHECK(guarded.frame() == 90);
}

TEST_CASE("offline: a NaN at the input becomes zero", "[backends]") {
  auto input = ramp(1, 10);
  input.channels[0][4] = std::numeric_limits<double>::quiet_NaN();
  auto clean = input;
  clean.channels[0][4] = 0.0;
  Smooth inner;
  Guarded guarded{inner, no_limits(1)};
  CHECK((render(guarded, input, 1)->channels == render(guarded, clean, 1)->channels));
}

TEST_CASE("offline: a sink that fails is an error", "[backends]") {
  Smooth inner;
  Guarded guarded{inner, no_limits(1)};
  const auto full = [](const double* const*, int) -> Status { return fail(Errc::BadFile, "", "full"); };
  const auto input = ramp(1, 10);
  CHECK(run_offline(guarded, offline_input(input), 1, {4}, full).error().code == Errc::BadFile);
  CHECK(guarded.frame() == 4);
}

TEST_CASE("health: load is a mean and a peak, gaps add up", "[backends]") {
  HealthMeter meter;
  CHECK(meter.read() == Health{});
  meter.block(64, 0.25);
  meter.block(128, 0.75);
  meter.gap(Gap::Output);
  meter.gap(Gap::Server);
  meter.lost(100);
  const auto health = meter.read();
  CHECK(health.blocks == 2);
  CHECK(health.frames == 192);
  CHECK(health.shortest_block == 64);
  CHECK(health.longest_block == 128);
  CHECK(health.mean_load == 0.5);
  CHECK(health.peak_load == 0.75);
  CHECK(health.late_blocks == 0);
  CHECK(health.xruns == 2);
  CHECK(health.gaps == std::array<std::int64_t, kGaps>{0, 1, 1, 0});
  CHECK(health.lost_frames == 100);
}

TEST_CASE("health: half of the blocks are below the median, one in a thousand above the high load",
          "[backends]") {
  HealthMeter meter;
  for (int n = 1; n <= 10000; ++n) meter.block(64, 1e-4 * n);
  const auto health = meter.read();
  CHECK(health.median_load == Approx(0.5).epsilon(0.016));
  CHECK(health.high_load == Approx(0.999).epsilon(0.016));
  CHECK(health.peak_load == 1.0);
  CHECK(health.late_blocks == 0);
  meter.block(64, 1.5);
  CHECK(meter.read().late_blocks == 1);
}

TEST_CASE("health: a load from 2^-20 to 2^6 is known within 1.6 %, and none is above the peak",
          "[backends]") {
  const auto [load, counted] =
      GENERATE(std::pair{0.0, 0.0}, std::pair{1e-9, 1e-9}, std::pair{0x1p-20, 0x1p-20}, std::pair{3e-5, 3e-5},
               std::pair{63.9, 63.9}, std::pair{1e9, 64.0});
  HealthMeter meter;
  meter.block(64, load);
  CHECK(meter.read().median_load == Approx(counted).epsilon(0.016));
}
