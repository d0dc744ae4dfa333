#include "backends/offline/offline.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

using namespace tactus;

namespace {

/// y = half of x plus half of what came out before: has a state, so that a lost or doubled frame shows.
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
  OfflineJob job;
  job.sample_rate = Hertz{22050};
  job.in_channels = 1;
  job.out_channels = 5;
  job.frames = 100;
  job.block_frames = {10, 30, 20};
  const auto health = run_offline(guarded, job);
  REQUIRE(health);
  CHECK(inner.format().sample_rate == Hertz{22050});
  CHECK(inner.format().in_channels == 1);
  CHECK(inner.format().out_channels == 5);
  CHECK(inner.format().max_frames == 30);
  // 10 + 30 + 20 + 10 + 30 = 100
  CHECK(health->blocks == 5);
  CHECK(health->frames == 100);
  CHECK(health->shortest_block == 10);
  CHECK(health->longest_block == 30);
  CHECK(health->xruns == 0);
  CHECK(guarded.frame() == 100);
}

TEST_CASE("offline: from a WAV file to a WAV file, silence after its end", "[backends]") {
  const auto folder =
      std::filesystem::temp_directory_path() / ("tactus_offline_" + std::to_string(std::random_device{}()));
  std::filesystem::create_directories(folder);
  REQUIRE(write_wav(folder / "in.wav", {48_kHz, {{1.0, 0.0, 0.5}}}));
  auto reader = WavReader::open(folder / "in.wav");
  auto writer = WavWriter::create(folder / "out.wav", 48_kHz, 1, WavEncoding::Float32);
  REQUIRE(reader);
  REQUIRE(writer);
  OfflineJob job;
  job.in_channels = job.out_channels = 1;
  job.frames = 6;
  job.block_frames = {2};
  job.source = source_of(*reader);
  job.sink = sink_into(*writer);
  Smooth inner;
  Guarded guarded{inner, no_limits(1)};
  REQUIRE(run_offline(guarded, job));
  REQUIRE(writer->close());
  const auto output = read_wav(folder / "out.wav");
  REQUIRE(output);
  CHECK(output->channels[0] == std::vector<double>{0.5, 0.25, 0.375, 0.1875, 0.09375, 0.046875});
  std::filesystem::remove_all(folder);
}

TEST_CASE("offline: a NaN at the input is made zero and counted", "[backends]") {
  auto input = ramp(1, 10);
  input.channels[0][4] = std::numeric_limits<double>::quiet_NaN();
  auto clean = input;
  clean.channels[0][4] = 0.0;
  Samples output{48_kHz, {{}}};
  OfflineJob job;
  job.in_channels = job.out_channels = 1;
  job.frames = 10;
  job.source = source_of(input);
  job.sink = sink_into(output);
  Smooth inner;
  Guarded guarded{inner, no_limits(1)};
  const auto health = run_offline(guarded, job);
  REQUIRE(health);
  CHECK(health->bad_input == 1);
  CHECK((output.channels == render(guarded, clean, 1)->channels));
}

TEST_CASE("offline: a job that makes no sense is refused in words", "[backends]") {
  Smooth inner;
  Guarded guarded{inner, {}};
  const auto message = [&](auto change) {
    OfflineJob job;
    job.frames = 10;
    change(job);
    const auto health = run_offline(guarded, job);
    return health ? std::string{} : to_string(health.error());
  };
  const auto input = ramp(2, 10);
  CHECK(message([](OfflineJob&) {}).empty());
  CHECK(message([](OfflineJob& job) { job.sample_rate = Hertz{0.0}; }) == "0 Hz is no sample rate");
  CHECK(message([](OfflineJob& job) { job.frames = -1; }) == "channels and frames cannot be negative");
  const std::string no_block =
      "there is no block size, or one that is out of range; give 1 to 1048576 frames";
  CHECK(message([](OfflineJob& job) { job.block_frames = {}; }) == no_block);
  CHECK(message([](OfflineJob& job) { job.block_frames = {16, 0}; }) == no_block);
  CHECK(message([&](OfflineJob& job) { job.source = source_of(input); }) ==
        "the input has 2 channels, but 0 are wanted; give a file with as many channels as the instrument has "
        "inputs");
}

TEST_CASE("offline: behaves as a backend", "[backends]") {
  Smooth inner;
  Guarded guarded{inner, {}};
  OfflineJob job;
  job.frames = 48;
  OfflineBackend backend{job};
  const auto devices = backend.devices();
  REQUIRE(devices);
  REQUIRE(devices->size() == 1);

  StreamRequest request;
  request.device = devices->front().id;
  request.sample_rate = Hertz{32e3};
  request.out_channels = 2;
  request.block_frames = 16;
  auto stream = backend.open(request, guarded);
  REQUIRE(stream);
  CHECK((*stream)->granted().format.sample_rate == Hertz{32e3});
  CHECK((*stream)->granted().format.out_channels == 2);
  CHECK((*stream)->granted().block_frames == 16);
  CHECK((*stream)->state() == StreamState::Stopped);
  REQUIRE((*stream)->start());
  CHECK((*stream)->state() == StreamState::Finished);
  CHECK((*stream)->health().frames == 48);
  CHECK_FALSE((*stream)->start());
  CHECK((*stream)->stop());
  CHECK((*stream)->stop());

  request.device = "offline:tape";
  CHECK(to_string(backend.open(request, guarded).error()) ==
        "there is no device 'offline:tape'; the only one here is 'offline:files'");
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
  CHECK(health.median_load == Approx(0.5).epsilon(0.03));
  CHECK(health.high_load == Approx(0.999).epsilon(0.03));
  CHECK(health.peak_load == 1.0);
  CHECK(health.late_blocks == 0);
  meter.block(64, 1.5);
  CHECK(meter.read().late_blocks == 1);
}
