#include "backends/loop/loop.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "engine/core/units.h"
#include "engine/dsp/generators/counter_noise.h"
#include "tests/support/error_summary.h"
#include "tests/support/wait_until.h"

using namespace tactus;

namespace {

constexpr auto kFast = LoopBackend::Pace::AsFastAsPossible;

/// Plays a list of samples on every output, keeps what comes in.
class Witness final : public BlockProcessor {
 public:
  explicit Witness(std::vector<double> samples) : play(std::move(samples)) {}

  Status prepare(const StreamFormat& format) override {
    channels = format.in_channels;
    outputs = format.out_channels;
    recorded.assign(static_cast<std::size_t>(channels), std::vector<double>(play.size()));
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    for (int n = 0; n < io.frames; ++n, ++frame) {
      const auto at = static_cast<std::size_t>(frame);
      const bool on = at < play.size();
      for (int c = 0; c < outputs; ++c) io.out[c][n] = on ? play[at] : 0.0;
      for (int c = 0; on && c < channels; ++c) recorded[static_cast<std::size_t>(c)][at] = io.in[c][n];
    }
  }

  std::vector<double> play;
  std::vector<std::vector<double>> recorded;
  int channels = 0, outputs = 0;
  std::atomic<std::int64_t> frame{0};
};

struct Run {
  StreamGranted granted;
  Health health;
  std::vector<std::vector<double>> recorded;
};

/// Plays `samples` on the first output of `card` until they are over; hears both inputs.
Run run(LoopBackend& backend, std::vector<double> samples, int block = 64) {
  Witness witness{std::move(samples)};
  Guarded guarded{witness, {{DriveGuard::Kind::Audio, {}}}};
  StreamRequest request;
  request.device = "loop:test";
  request.in_channels = 2;
  request.out_channels = 1;
  request.block_frames = block;
  auto stream = backend.open(request, guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  const auto frames = static_cast<std::int64_t>(witness.play.size());
  REQUIRE(test::wait_until([&] { return witness.frame >= frames; }, std::chrono::seconds{20}));
  REQUIRE((*stream)->stop());
  return {(*stream)->granted(), (*stream)->health(), std::move(witness.recorded)};
}

Run run(const LoopCard& card, std::vector<double> samples, int block = 64) {
  LoopBackend backend{kFast};
  backend.add("loop:test", card);
  return run(backend, std::move(samples), block);
}

std::vector<double> impulse_at(std::size_t frame, std::size_t frames) {
  std::vector<double> samples(frames);
  samples[frame] = 0.5;
  return samples;
}

std::vector<double> sine(double turns, std::size_t frames, double level = 0.5) {
  std::vector<double> samples(frames);
  for (std::size_t n = 0; n < frames; ++n)
    samples[n] = level * std::sin(2 * kPi * turns * static_cast<double>(n));
  return samples;
}

LoopCard delayed(double frames) {
  LoopCard card;
  card.delay_frames = frames;
  return card;
}

}  // namespace

TEST_CASE("loop: a whole delay is exact, whatever the block", "[loop]") {
  const int block = GENERATE(1, 7, 64, 100, 512);
  CAPTURE(block);
  const auto recorded = run(delayed(100.0), impulse_at(50, 400), block).recorded;
  std::vector<double> expected(400);
  expected[150] = 0.5;
  CHECK(recorded[0] == expected);
  CHECK(recorded[1] == std::vector<double>(400));
}

TEST_CASE("loop: buffers add their blocks to the delay, and the driver says all of it", "[loop]") {
  auto card = delayed(10.0);
  card.delay_blocks = 2;
  const auto played = run(card, impulse_at(50, 400), 32);
  CHECK(played.recorded[0][50 + 10 + 64] == 0.5);
  CHECK(*played.granted.input_latency_frames + *played.granted.output_latency_frames == 74.0);
}

TEST_CASE("loop: a clock that is faster makes the delay grow by so much a frame", "[loop]") {
  auto card = delayed(200.25);
  card.input_ppm = 100.0;
  constexpr std::size_t kFrames = 40000;
  const double turns = 0.05;
  const auto recorded = run(card, sine(turns, kFrames)).recorded[0];
  for (std::size_t n = 1000; n < kFrames; n += 997) {
    CAPTURE(n);
    const double at = static_cast<double>(n) / (1.0 + 100e-6) - 200.25;
    CHECK(recorded[n] == Approx(0.5 * std::sin(2 * kPi * turns * at)).margin(2e-5));
  }
}

TEST_CASE("loop: lost frames shorten the delay, repeated ones lengthen it, and are counted when reported",
          "[loop]") {
  auto card = delayed(300.0);
  const bool reported = GENERATE(true, false);
  card.drops_reported = reported;
  card.drops = {{Seconds{0.01}, Seconds{0.0}, 20}, {Seconds{0.02}, Seconds{0.0}, -50}};
  const auto played = run(card, impulse_at(250, 2000));
  CHECK(played.recorded[0][250 + 280] == 0.5);  // after the first at 480, before the second at 960
  CHECK(played.health.xruns == (reported ? 2 : 0));
  CHECK(played.health.lost_frames == (reported ? 20 : 0));
  const auto later = run(card, impulse_at(1000, 2000));
  CHECK(later.recorded[0][1000 + 330] == 0.5);
}

TEST_CASE("loop: what is unstable differs between openings, in blocks or frames", "[loop]") {
  LoopBackend backend{kFast};
  auto card = delayed(200.0);
  card.unstable_blocks = 3;
  backend.add("loop:test", card);
  std::set<std::size_t> delays;
  for (int turn = 0; turn < 12; ++turn) {
    const auto recorded = run(backend, impulse_at(0, 600)).recorded[0];
    for (std::size_t n = 0; n < recorded.size(); ++n)
      if (recorded[n] == 0.5) delays.insert(n);
  }
  CHECK(delays == std::set<std::size_t>{200, 264, 328, 392});
}

TEST_CASE("loop: the monitor plays the input once more, a frame later or by the buffers too", "[loop]") {
  auto card = delayed(100.0);
  card.delay_blocks = 2;
  card.monitor_gain = 0.5;
  card.monitor_in_software = GENERATE(false, true);
  const auto recorded = run(card, impulse_at(0, 1000), 64).recorded[0];
  CHECK(recorded[228] == 0.5);
  CHECK(recorded[228 + 101 + (card.monitor_in_software ? 128u : 0u)] == 0.25);
}

TEST_CASE("loop: a coupling capacitor is 3.01 dB down at its corner, 45 degrees ahead", "[loop]") {
  auto card = delayed(100.0);
  card.high_pass = 480_Hz;
  const auto played = sine(0.01, 10000);
  const auto recorded = run(card, played).recorded[0];
  double in_phase = 0.0, ahead = 0.0;
  for (std::size_t n = 5000; n < 10000; ++n) {
    const double angle = 2 * kPi * 0.01 * static_cast<double>(n - 100);
    in_phase += recorded[n] * std::sin(angle) / 2500.0;
    ahead += recorded[n] * std::cos(angle) / 2500.0;
  }
  CHECK(in_phase == Approx(0.25).epsilon(1e-6));
  CHECK(ahead == Approx(0.25).epsilon(1e-6));
}

TEST_CASE("loop: gain, offset, steps and the end of the range are those that were asked for", "[loop]") {
  auto card = delayed(64.0);
  card.gain = -2.0;
  card.dc = 0.01;
  card.clip = 0.3;
  std::vector<double> ramp(1000);
  for (std::size_t n = 0; n < ramp.size(); ++n) ramp[n] = 0.0003 * static_cast<double>(n);
  const auto recorded = run(card, ramp).recorded[0];
  CHECK(recorded[64 + 100] == Approx(0.01 - 0.06));
  CHECK(recorded[64 + 900] == -0.3);
  card = delayed(64.0);
  card.bits = 8;
  const auto rounded = run(card, ramp).recorded[0];
  CHECK(rounded[64 + 500] == std::rint(0.15 * 128) / 128);
}

TEST_CASE("loop: noise has the rms that was asked for, and another course on each channel", "[loop]") {
  auto card = delayed(64.0);
  card.noise = 0.01;
  constexpr std::size_t kFrames = 40000;
  const auto recorded = run(card, std::vector<double>(kFrames)).recorded;
  double power = 0.0, common = 0.0;
  for (std::size_t n = 0; n < kFrames; ++n) {
    power += recorded[0][n] * recorded[0][n] / kFrames;
    common += recorded[0][n] * recorded[1][n] / kFrames;
  }
  CHECK(power == Approx(1e-4).epsilon(5 * std::sqrt(2.0 / kFrames)));
  CHECK(std::abs(common) < 5e-4 / std::sqrt(static_cast<double>(kFrames)));
}

TEST_CASE("loop: cables end where they are plugged in", "[loop]") {
  auto card = delayed(64.0);
  card.cable = LoopCard::Cable::Crossed;
  const auto crossed = run(card, impulse_at(0, 200)).recorded;
  CHECK(crossed[0][64] == 0.0);
  CHECK(crossed[1][64] == 0.5);
  card.cable = LoopCard::Cable::None;
  CHECK(run(card, impulse_at(0, 200)).recorded ==
        std::vector<std::vector<double>>(2, std::vector<double>(200)));
}

TEST_CASE("loop: an automatic gain brings soft and loud to the same peak", "[loop]") {
  auto card = delayed(64.0);
  card.agc = true;
  for (const double level : {0.003, 0.03, 0.9}) {
    const auto recorded = run(card, sine(0.05, 96000, level)).recorded[0];
    double peak = 0.0;
    for (std::size_t n = 90000; n < recorded.size(); ++n) peak = std::max(peak, std::abs(recorded[n]));
    CHECK(peak == Approx(0.1).epsilon(0.02));  // the detector falls a little short of a sine's crests
  }
}

TEST_CASE("loop: an echo canceller leaves ever less of what is played", "[loop]") {
  auto card = delayed(500.25);
  card.echo_cancel = true;
  std::vector<double> noise(144000);
  for (std::size_t n = 0; n < noise.size(); ++n)
    noise[n] = 0.2 * CounterNoise{7, 0}.uniform(static_cast<std::int64_t>(n));
  const auto recorded = run(card, noise).recorded[0];
  const auto power = [&](std::size_t from) {
    double sum = 0.0;
    for (std::size_t n = from; n < from + 1000; ++n) sum += recorded[n] * recorded[n] / 1000.0;
    return sum;
  };
  CHECK(power(600) > 0.1 * 0.04 / 3);
  CHECK(power(70000) < 0.1 * power(600));
  CHECK(power(140000) < 0.1 * power(70000));
}

TEST_CASE("loop: health tells what the driver does not: the true rate and the true blocks", "[loop]") {
  auto card = delayed(200.0);
  card.rate_factor = 44.1 / 48.0;
  card.block_factor = 0.5;
  const auto played = run(card, std::vector<double>(20000));
  CHECK(played.granted.format.sample_rate == 48_kHz);
  CHECK(played.granted.block_frames == 64);
  CHECK(played.health.longest_block == 32);
  // The seconds end where the last block begins.
  CHECK(static_cast<double>(played.health.frames - 32) / played.health.seconds == Approx(44100.0));
}

TEST_CASE("loop: a delay that cannot be is refused, a block longer than the delay becomes shorter",
          "[loop]") {
  CHECK(run(delayed(20.0), std::vector<double>(100), 64).granted.block_frames == 20);
  CHECK(run(delayed(60.5), std::vector<double>(100), 64).granted.block_frames == 12);
  LoopBackend backend{kFast};
  backend.add("loop:test", delayed(10.5));
  Witness witness{{}};
  Guarded guarded{witness, {}};
  StreamRequest request;
  request.device = "loop:test";
  request.in_channels = request.out_channels = 1;
  const auto refused = backend.open(request, guarded);
  REQUIRE_FALSE(refused);
  CHECK(test::summary(refused) == "OutOfRange 10.5 48");
}

TEST_CASE("loop: a device that says what it is can be added by its id alone", "[loop]") {
  LoopBackend backend{kFast};
  REQUIRE(backend.add("loop:delay=77,gain=-6dB"));
  REQUIRE(backend.add("loop:agc"));
  CHECK(backend.devices()->size() == loop_cards().size() + 1);
  CHECK_FALSE(backend.add("loop:nothing"));
  CHECK_FALSE(backend.add("jack:system"));
}

TEST_CASE("loop: in real time it takes as long as it lasts", "[loop]") {
  LoopBackend backend{LoopBackend::Pace::RealTime};
  backend.add("loop:test", delayed(480.0));
  const auto begin = std::chrono::steady_clock::now();
  (void)run(backend, std::vector<double>(4800), 480);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  CHECK(took.count() >= 0.1);  // a busy machine makes it later, nothing makes it earlier
}
