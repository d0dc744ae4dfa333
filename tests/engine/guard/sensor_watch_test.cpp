#include "engine/guard/sensor_watch.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "engine/guard/guarded.h"

using namespace tactus;

namespace {

constexpr Hertz kRate = 48_kHz;
constexpr int kPatience = 1920;  // 40 ms

std::vector<double> noise(int frames, double size, unsigned seed = 1) {
  std::mt19937 random{seed};
  std::vector<double> samples(static_cast<std::size_t>(frames));
  for (auto& sample : samples) sample = size * std::uniform_real_distribution<double>{-1, 1}(random);
  return samples;
}

std::vector<double> then(std::vector<double> samples, int frames, double value) {
  samples.insert(samples.end(), static_cast<std::size_t>(frames), value);
  return samples;
}

/// The frame of the first fault, or -1.
int found(const std::vector<double>& samples, int block, SensorWatch::Fault& fault) {
  SensorWatch watch{kRate};
  for (int done = 0; done < static_cast<int>(samples.size()); done += block) {
    const int frames = std::min(block, static_cast<int>(samples.size()) - done);
    if (const auto here = watch.observe(samples.data() + done, frames)) {
      fault = here->fault;
      return done + here->frame;
    }
  }
  return -1;
}

}  // namespace

TEST_CASE("sensor_watch: stuck bit for bit after noise is found 40 ms later, whatever the block", "[core]") {
  const auto samples = then(then(noise(5000, 1e-5), 3000, 0.25), 100, 0.3);
  const int block = GENERATE(1, 7, 64, 500, 4096, 10'000);
  SensorWatch::Fault fault{};
  // The value first stands at frame 5000; the 1,920th frame that repeats it is frame 6920.
  CHECK(found(samples, block, fault) == 5000 + kPatience);
  CHECK(fault == SensorWatch::Fault::Stuck);
}

TEST_CASE("sensor_watch: a sensor at the end of full scale is found 40 ms later, noisy or not", "[core]") {
  const int block = GENERATE(1, 64, 4096);
  const double end = GENERATE(1.0, -1.0);
  auto samples = then(noise(1000, 0.1), 4000, end);
  for (std::size_t n = 1000; n < samples.size(); n += 3)
    samples[n] = 0.9993 * end;  // the converter's last bits
  SensorWatch::Fault fault{};
  CHECK(found(samples, block, fault) == Approx(1000 + kPatience).margin(1));
  CHECK(fault == SensorWatch::Fault::Railed);
  CHECK(found(std::vector<double>(4000, end), block, fault) == Approx(kPatience).margin(1));
}

TEST_CASE("sensor_watch: a sensor that gives no numbers any more is found 40 ms later", "[core]") {
  SensorWatch::Fault fault{};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(found(then(noise(5000, 1e-3), 3000, nan), 64, fault) == Approx(5000 + kPatience).margin(1));
  CHECK(fault == SensorWatch::Fault::Stuck);
}

TEST_CASE("sensor_watch: what may rest is left alone", "[core]") {
  SensorWatch::Fault fault{};
  CHECK(found(std::vector<double>(50'000, 0.0), 64, fault) == -1);     // digital silence
  CHECK(found(std::vector<double>(50'000, 0.5), 64, fault) == -1);     // never noisy
  CHECK(found(noise(50'000, 1.0), 64, fault) == -1);                   // loud
  CHECK(found(then(noise(50'000, 0.1), 1900, 0.0), 64, fault) == -1);  // short
  std::vector<double> finger(50'000, 0.7);  // a calculated finger that moves and then rests
  for (int n = 0; n < 20'000; ++n)
    finger[static_cast<std::size_t>(n)] = 0.7 * std::sin(n * 1.5707963 / 20'000);
  CHECK(found(finger, 64, fault) == -1);
  std::vector<double> ring(50'000, 0.0);  // a struck lens at 3 kHz, quantised to 24 bits, dies away to 0
  for (int n = 0; n < 50'000; ++n)
    ring[static_cast<std::size_t>(n)] =
        std::nearbyint(std::exp(-n / 400.0) * std::sin(n * 2 * 3.1415926 * 3000 / 48'000) * 8388608) /
        8388608;
  CHECK(found(ring, 64, fault) == -1);
  std::vector<double> square(50'000);  // as loud as can be, but it moves
  for (std::size_t n = 0; n < square.size(); ++n) square[n] = n / 480 % 2 == 0 ? 1.0 : -1.0;
  CHECK(found(square, 64, fault) == -1);
}

TEST_CASE("sensor_watch: a faulty sensor silences every drive within 50 ms, until the user arms again",
          "[core]") {
  class Through final : public BlockProcessor {
   public:
    Status prepare(const StreamFormat&) override { return {}; }
    void process(const BlockIo& io) noexcept override {
      for (int n = 0; n < io.frames; ++n) io.out[0][n] = 0.5, io.out[1][n] = 0.5;
    }
  } through;
  Guarded guarded{through, {{DriveGuard::Kind::Drive, {}}, {DriveGuard::Kind::Audio, {}}}};
  REQUIRE(guarded.prepare({.sample_rate = kRate, .in_channels = 2, .out_channels = 2, .max_frames = 4096}));
  const auto living = noise(9600, 1e-4, 2), stuck = then(noise(4800, 1e-4), 4800, 0.1);
  std::vector<double> drive(9600), audio(9600);
  const auto play = [&](const std::vector<double>& a, const std::vector<double>& b) {
    const double* in[] = {a.data(), b.data()};
    double* out[] = {drive.data(), audio.data()};
    guarded.process({in, out, 9600});
  };
  play(living, stuck);
  CHECK(drive[4800 + kPatience] == 0.5);
  CHECK(drive[4800 + 2400] == 0.0);  // 50 ms
  CHECK(audio[9599] == 0.5);
  GuardEvent event;
  REQUIRE(guarded.take_event(event));
  CHECK(event == GuardEvent{4800 + kPatience, GuardEvent::Kind::SensorStuck, 1});
  CHECK_FALSE(guarded.take_event(event));
  play(living, living);
  CHECK(drive[9599] == 0.0);
  REQUIRE(guarded.post({JournalEntry::kNow, JournalEntry::Kind::Arm, JournalEntry::kAllChannels, 1.0}));
  play(living, noise(9600, 1e-4, 3));
  CHECK(drive[9599] == 0.5);
  REQUIRE(guarded.post({JournalEntry::kNow, JournalEntry::Kind::Arm, JournalEntry::kAllChannels, 1.0}));
  play(living, std::vector<double>(9600, 0.1));  // still stuck: it is found again
  REQUIRE(guarded.take_event(event));
  CHECK(drive[9599] == 0.0);
}
