#include "backends/paced/paced_loop.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <vector>

using namespace tactus;
using namespace std::chrono_literals;
using Time = FrameTimer::Time;

namespace {

/// A clock that the test sets: each wake-up is late by what `late` says.
class GivenTimer final : public FrameTimer {
 public:
  Time now() noexcept override { return time; }
  void wait_until(Time due) noexcept override { time = std::max(time, due + late(wakes++)); }
  Time time{0};
  int wakes = 0;
  std::function<Time(int)> late = [](int) { return 0ns; };
};

/// Records what is done with it.
class Recorder final : public FrameDevice {
 public:
  int in_channels() const override { return 1; }
  int out_channels() const override { return 1; }
  bool read(std::int64_t frame, float* in) noexcept override {
    frames.push_back(frame);
    *in = 0.25f;
    return frame != gone_at_read;
  }
  bool write(std::int64_t frame, const float* out) noexcept override {
    value = *out;
    written.push_back(frame);
    return frame != gone_at_write;
  }
  void to_zero() noexcept override {
    value = 0.0f;
    zeros.push_back(frames.size());
  }
  std::vector<std::int64_t> frames, written;
  std::vector<std::size_t> zeros;  ///< frames before each
  float value = -1.0f;
  std::int64_t gone_at_read = -1, gone_at_write = -1;
};

struct Run {
  GivenTimer timer;
  Recorder device;
  std::atomic<bool> stops{false};
  std::vector<std::int64_t> skipped, from_zero;  ///< frames left out before each frame; of those from zero

  /// `frames`: after which it stops. `takes`: how long the frame of this number does.
  void run(
      PacedLoop& loop, int frames, const std::function<Time(int)>& takes = [](int) { return 0ns; }) {
    loop.run(timer, stops, [&](const float* in, float* out, const PacedFrame& frame) {
      *out = 2 * *in;
      skipped.push_back(frame.skipped);
      if (frame.from_zero) from_zero.push_back(frame.skipped);
      const int n = static_cast<int>(skipped.size()) - 1;
      timer.time += takes(n);
      stops = n + 1 == frames;
    });
  }
};

}  // namespace

TEST_CASE("paced loop: the histogram has exactly the lateness of the wake-ups, and no frame is skipped") {
  Run run;
  run.timer.late = [](int n) { return Time{1000 * (n % 50)}; };  // 0 to 49 us
  PacedLoop loop{run.device, 1000};
  run.run(loop, 5000);
  for (int us = 0; us < 50; ++us) REQUIRE(loop.lateness().count(us) == 100);
  CHECK(loop.lateness().total() == 5000);
  CHECK(loop.lateness().longest() == 49us);
  CHECK(loop.skipped() == 0);
  CHECK(loop.overruns() == 0);
  CHECK(run.device.frames.size() == 5000);
}

TEST_CASE("paced loop: a frame that takes two and a half periods costs one frame, which is counted") {
  Run run;
  PacedLoop loop{run.device, 1000};
  run.run(loop, 20, [](int n) { return n == 10 ? Time{2'500'000} : 0ns; });
  std::vector<std::int64_t> expected;
  for (std::int64_t k = 0; k <= 20; ++k)
    if (k != 11) expected.push_back(k);  // at 12.5 ms frame 12 is due
  CHECK(run.device.frames == expected);
  CHECK(loop.overruns() == 1);
  CHECK(loop.skipped() == 1);
  CHECK(run.skipped[11] == 1);
  CHECK(loop.lateness().count(1500) == 1);
  CHECK(loop.lateness().longest() == 1500us);
  CHECK(loop.answer().longest() == 2500us);
}

TEST_CASE("paced loop: the output is at zero after the last frame") {
  Run run;
  PacedLoop loop{run.device, 10'000};
  run.run(loop, 3);
  CHECK(run.device.written.size() == 3);
  CHECK(run.device.value == 0.0f);
  CHECK(run.device.zeros == std::vector<std::size_t>{3});
  CHECK_FALSE(loop.lost());
}

TEST_CASE("paced loop: a device that fails ends it, with the output at zero") {
  Run run;
  const bool at_read = GENERATE(true, false);
  (at_read ? run.device.gone_at_read : run.device.gone_at_write) = 5;
  PacedLoop loop{run.device, 10'000};
  run.run(loop, 100);
  CHECK(loop.lost());
  CHECK(run.device.frames.size() == 6);
  CHECK(run.device.written.size() == (at_read ? 5 : 6));
  CHECK(run.device.value == 0.0f);
}

TEST_CASE("paced loop: before a frame that is late by 500 ms the output is at zero") {
  Run run;
  const auto late = GENERATE(499'999us, 500'000us);
  run.timer.late = [late](int n) { return n == 7 ? Time{late} : 0ns; };
  PacedLoop loop{run.device, 1000};
  run.run(loop, 10);
  const std::vector<std::size_t> at_end{10}, with_stall{7, 10};
  CHECK(run.device.zeros == (late < 500ms ? at_end : with_stall));
  CHECK(loop.skipped() == (late < 500ms ? 499 : 500));
  CHECK(run.from_zero == (late < 500ms ? std::vector<std::int64_t>{} : std::vector<std::int64_t>{500}));
}

namespace {

/// x' = u in continuous time: read and written when the clock says so.
class Integrator final : public FrameDevice {
 public:
  explicit Integrator(GivenTimer& timer) : timer_(timer) {}
  int in_channels() const override { return 1; }
  int out_channels() const override { return 1; }
  bool read(std::int64_t, float* in) noexcept override {
    go_on();
    *in = static_cast<float>(x_);
    positions.push_back(x_);
    return true;
  }
  bool write(std::int64_t, const float* out) noexcept override {
    go_on();
    u_ = static_cast<double>(*out);
    return true;
  }
  void to_zero() noexcept override {}
  std::vector<double> positions;

 private:
  void go_on() {
    x_ += u_ * std::chrono::duration<double>(timer_.time - last_).count();
    last_ = timer_.time;
  }
  GivenTimer& timer_;
  Time last_{0};
  double x_ = 0.0, u_ = 0.0;
};

}  // namespace

// x[n+1] = x[n] + u[n-1] e + u[n] (T - e), u = g (r - x), where the output changes e after the input was
// read. With z = exp(j w T) and H = X / R of the closed loop, L = H / (1 - H) is g ((T - e) + e / z) / (z -
// 1), so that e = (T - L (z - 1) / g) / (1 - 1 / z).
TEST_CASE("paced loop: the phase of a closed loop shows the time from input to output, below one frame") {
  using Complex = std::complex<double>;
  const auto takes = GENERATE(0us, 20us, 150us, 900us);
  constexpr double kPeriod_s = 1e-3, kGain = 300.0;
  constexpr int kFrames = 2000, kCycle = 20;
  const double w = 2 * std::numbers::pi / kCycle;
  GivenTimer timer;
  Integrator plant{timer};
  PacedLoop loop{plant, 1000};
  std::atomic<bool> stops{false};
  int n = 0;
  loop.run(timer, stops, [&](const float* in, float* out, const PacedFrame&) {
    *out = static_cast<float>(kGain * (std::cos(w * n) - static_cast<double>(*in)));
    stops = ++n == kFrames;
    timer.time += takes;
  });
  Complex response = 0.0;
  for (int k = kFrames / 2; k < kFrames; ++k)
    response += plant.positions[index(k)] * std::polar(4.0 / kFrames, -w * k);
  const Complex z = std::polar(1.0, w), open = response / (1.0 - response);
  const Complex delay = (kPeriod_s - open * (z - 1.0) / kGain) / (1.0 - 1.0 / z);
  // Samples of 24 bits.
  CHECK(delay.real() == Approx(std::chrono::duration<double>(takes).count()).margin(1e-9));
  CHECK(delay.imag() == Approx(0.0).margin(1e-9));
  CHECK(loop.answer().longest() == takes);
  CHECK(loop.skipped() == 0);
}
