#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/cards/ways.h"
#include "tests/support/sound_server.h"
#include "tests/support/wait_until.h"

// The card of known delay that other tests trust.

using namespace tactus;

namespace {

/// Plays a sine and compares what comes back.
class Sine final : public BlockProcessor {
 public:
  static constexpr int kCycle = 48;      ///< [frames] 1 kHz
  static constexpr int kFrames = 4800;   ///< that are looked at: whole cycles
  static constexpr int kSkipped = 4800;  ///< before that

  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    for (int n = 0; n < io.frames; ++n, ++frame_) {
      const auto turn = std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(frame_ % kCycle) / kCycle);
      if (frame_ >= kSkipped && frame_ < kSkipped + kFrames) {
        sum_ += io.in[0][n] / turn;
        power_ += io.in[0][n] * io.in[0][n];
      }
      io.out[0][n] = 0.5 * turn.imag();
    }
    done = frame_ >= kSkipped + kFrames;
  }
  /// g e^(-2 pi i d / kCycle) for a gain g and a delay d [frames]: 0.5 sin becomes g/2 * turn / 2i.
  std::complex<double> response() const { return sum_ * std::complex{0.0, 4.0} / double{kFrames}; }
  /// Mean power of what is not the sine.
  double noise() const { return power_ / kFrames - std::norm(response()) / 8; }

  std::atomic<bool> done{false};

 private:
  int frame_ = 0;
  std::complex<double> sum_;
  double power_ = 0.0;
};

}  // namespace

TEST_CASE("delay client: gain, noise and a fraction of a frame are what was asked for", "[cards]") {
  const auto server = test::start_sound_server();
  test::DelayClient card{{.delay_frames = 960.25, .gain = -0.5, .noise = 0.01}};
  Sine sine;
  Guarded guarded{sine, {{DriveGuard::Kind::Audio, DriveLimits{}}}};
  guarded.disable_sensor_watch();
  StreamRequest request;
  request.device = "jack:" + card.name();
  request.in_channels = request.out_channels = 1;
  request.client_name = card.name() + "-sine";
  const auto jack = test::backend_named("jack");
  const auto stream = jack->open(request, guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  REQUIRE(test::wait_until([&] { return sine.done.load(); }));
  REQUIRE((*stream)->stop());
  const auto upright = -sine.response();  // the gain is negative
  const double delay = -std::arg(upright) * Sine::kCycle / (2 * std::numbers::pi);
  CHECK(std::remainder(delay - (960.25 + 256), Sine::kCycle) == Approx(0.0).margin(0.01));
  CHECK(std::abs(upright) == Approx(0.5).epsilon(0.001));
  CHECK(sine.noise() == Approx(0.01 * 0.01 / 3).epsilon(0.1));  // of even noise with this peak
}
