// One instrument on two devices: what goes from one to the other, and when. Both devices are simulated, their
// blocks and the clock come from the test. On devices of a real kernel: tests/cards/sdl.
#include "backends/second_device/two_devices.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <vector>

#include "engine/core/channels.h"
#include "engine/core/not_realtime.h"
#include "engine/runtime/player.h"
#include "tests/support/fake_backend.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using test::FakeBackend;
using test::FakeWorld;

namespace {

constexpr int kBlock = 64;
constexpr double kRate_hz = 48000, kPoll_s = 0.001;

/// Four channels in and out. Outputs are `out`; the inputs of the last block are kept.
class Probe final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& format) override {
    granted = format;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    const NotRealtime allocates;
    for (int c = 0; c < granted.in_channels; ++c) in[c].assign(io.in[c], io.in[c] + io.frames);
    for (int c = 0; c < granted.out_channels; ++c)
      for (int n = 0; n < io.frames; ++n) io.out[c][n] = out(c, frame + n);
    frame += io.frames;
  }
  StreamFormat granted;
  std::map<int, std::vector<double>> in;
  std::function<double(int channel, std::int64_t frame)> out = [](int, std::int64_t) { return 0.0; };
  std::int64_t frame = 0;
};

/// A card with two channels, channel 0 and 3 of the processor, and a gamepad with channels 1 and 2.
struct Desk {
  explicit Desk(std::vector<int> channels = {5, kSecondDevice + 2, kSecondDevice, 6},
                BlockProcessor* player = nullptr)
      : guarded{player != nullptr ? *player : probe,
                std::vector<GuardedChannel>(channels.size(),
                                            {DriveGuard::Kind::Audio, {.ceiling = 1.0}, {false, false}})} {
    card_world.block = kBlock;
    request.device = "fake:card";
    request.second_device = "fake:pad";
    request.in_channels = request.out_channels = static_cast<int>(channels.size());
    request.in_map = request.out_map = std::move(channels);
    request.sample_rate = Hertz{kRate_hz};
    auto card_backend = std::make_unique<FakeBackend>(card_world);
    auto pad_backend = std::make_unique<FakeBackend>(pad_world);
    card = card_backend.get();
    pad = pad_backend.get();
    both = make_two_devices(std::move(card_backend), std::move(pad_backend), [this] { return seconds; });
    guarded.disable_sensor_watch();
  }
  void open() {
    auto opened = both->open(request, guarded);
    INFO((opened ? "" : to_string(opened.error())));
    REQUIRE(opened);
    stream = std::move(*opened);
    REQUIRE(stream->start());
  }
  /// One block of the card; the values of its inputs are that of `value`.
  void play(double value = 0.0) {
    ChannelBuffers in{2, kBlock}, out{2, kBlock};
    for (auto* channel : in) std::fill_n(channel, kBlock, value);
    card->guarded->process({in.data(), out.data(), kBlock});
    card_out.assign(out[0], out[0] + kBlock);
  }
  /// One reading of the gamepad; the levels that it gets.
  std::vector<double> poll(double first, double second) {
    ChannelBuffers in{2, 8}, out{2, 8};
    std::fill_n(in[0], 8, first);
    std::fill_n(in[1], 8, second);
    pad->guarded->process({in.data(), out.data(), 8});
    return {out[0][0], out[1][0]};
  }

  double seconds = 10.0;
  FakeWorld card_world, pad_world;
  FakeBackend *card = nullptr, *pad = nullptr;
  std::unique_ptr<Backend> both;
  Probe probe;
  Guarded guarded;
  StreamRequest request;
  std::unique_ptr<Stream> stream;
  std::vector<double> card_out;
};

}  // namespace

TEST_CASE("two devices: each gets its own channels, and the processor all in their order") {
  Desk desk;
  desk.open();
  CHECK(desk.probe.granted.in_channels == 4);
  CHECK(desk.probe.granted.out_channels == 4);
  CHECK(desk.card_world.requests.back().in_map == std::vector{5, 6});
  CHECK(desk.pad_world.requests.back().out_map == std::vector{2, 0});
  const auto& granted = desk.stream->granted();
  CHECK(granted.device == "fake:card");
  CHECK(granted.second->device == "fake:pad");
  CHECK(granted.second->input_delay == Seconds{0.002});
  desk.play(0.25);
  CHECK(desk.probe.in[0] == std::vector<double>(kBlock, 0.25));
  CHECK(desk.probe.in[3] == std::vector<double>(kBlock, 0.25));
  CHECK(desk.probe.in[1] == std::vector<double>(kBlock, 0.0));
}

TEST_CASE("two devices: inputs of the second are exactly 2 ms later than those of the first") {
  // The gamepad shows the time itself; between two readings it is interpolated, so no error remains.
  Desk desk;
  desk.open();
  double next_poll = desk.seconds;
  const double first = desk.seconds, block_s = kBlock / kRate_hz;
  for (int n = 0; n < 60; ++n) {
    const double block_time = first + n * block_s;
    for (; next_poll <= block_time; next_poll += kPoll_s) {
      desk.seconds = next_poll;
      (void)desk.poll(next_poll, -next_poll);
    }
    desk.seconds = block_time;
    desk.play();
    if (n < 5) continue;
    for (int k = 0; k < kBlock; ++k) {
      const double captured = block_time + (k + 1 - kBlock) / kRate_hz;
      REQUIRE(desk.probe.in[1][index(k)] == Approx(captured - 0.002).margin(1e-9));
      REQUIRE(desk.probe.in[2][index(k)] == Approx(0.002 - captured).margin(1e-9));
    }
  }
}

TEST_CASE(
    "two devices: outputs reach the second 2.5 ms after they are computed, as means over a millisecond") {
  // A ramp has the mean of its middle: the level is exact, and 2.5 ms old.
  Desk desk;
  desk.probe.out = [](int channel, std::int64_t frame) {
    return channel == 0 || channel == 3 ? 0.0
                                        : (channel == 1 ? 1.0 : -0.5) * static_cast<double>(frame) / kRate_hz;
  };
  desk.open();
  double next_poll = desk.seconds;
  const double first = desk.seconds, block_s = kBlock / kRate_hz;
  for (int n = 0; n < 200; ++n) {
    desk.seconds = first + n * block_s;
    desk.play();
    for (; next_poll < first + (n + 1) * block_s; next_poll += kPoll_s) {
      desk.seconds = next_poll;
      const auto levels = desk.poll(0, 0);
      if (n < 100) continue;  // soft start
      REQUIRE(levels[0] == Approx(next_poll - 0.0025 - first).margin(1e-9));
      REQUIRE(levels[1] == Approx(-0.5 * (next_poll - 0.0025 - first)).margin(1e-9));
    }
  }
}

#if defined(TACTUS_HAS_ODE)

namespace {

/// A handle on the second device, coupled to a body that is too heavy to move, and a tone that shakes it.
const std::string kWorldOnDevice = R"(format = 1
name = "n"
[inputs]
unused = {}
encoder = {}
[worlds.hall]
block = { type = "box", width = "2 cm", depth = "2 cm", height = "2 cm", mass = "1e9 kg" }
hand = { type = "handle", on = "block", x = "1 m * encoder", stiffness = "10 N/m", passivity = "0 N s/m" }
[nodes]
tone = { type = "sine", frequency = "125 Hz", level = 0.5 }
[outputs]
sound = { from = "tone", kind = "audio" }
force = { from = "hall.hand.fx / 1 N", kind = "audio" }
shake = { from = "tone", kind = "audio" }
)";

}  // namespace

TEST_CASE("two devices: a handle feels a world 4.5 ms and a block after it moved, and a tone 2.5 ms late") {
  const auto player = test::engine_of(kWorldOnDevice);
  Desk desk{{0}, player.get()};
  desk.request.in_channels = 2;
  desk.request.in_map = {0, kSecondDevice};
  desk.request.out_channels = 3;
  desk.request.out_map = {0, kSecondDevice, kSecondDevice + 1};
  desk.open();
  double next_poll = desk.seconds;
  const double first = desk.seconds, block_s = kBlock / kRate_hz;
  const auto place = [&](double seconds) {
    return 0.01 * std::sin(2 * std::numbers::pi * 2 * (seconds - first));
  };
  // Frames that come in with a block were captured while the one before it was played.
  const double late_s = 0.0045 + (kBlock - 1) / kRate_hz;
  std::complex<double> component;
  int polls = 0;
  double largest = 0;
  for (int n = 0; n < 1500; ++n) {
    desk.seconds = first + n * block_s;
    desk.play();
    for (; next_poll < first + (n + 1) * block_s; next_poll += kPoll_s) {
      desk.seconds = next_poll;
      const auto levels = desk.poll(place(next_poll), 0);
      if (next_poll < first + 1.0 || polls >= 800) continue;  // whole periods
      ++polls;
      largest = std::max(largest, std::abs(levels[0] + 10 * place(next_poll - late_s)));
      component += levels[1] * std::polar(2.0 / 800, -2 * std::numbers::pi * 125 * (next_poll - first));
    }
  }
  REQUIRE(polls == 800);
  // The means and the lines of both ways bend 2 Hz by (2 pi 2 Hz 1 ms)^2 / 8 of 0.1 N at most.
  CHECK(largest < 1e-5);
  // A mean over a millisecond. A reading lies half a frame beside the middle of one, on the line to the next.
  const double x = std::numbers::pi * 125 * 0.001, share = 0.5 / (0.001 * kRate_hz);
  const double line = std::sqrt(1 - 2 * share * (1 - share) * (1 - std::cos(2 * x)));
  CHECK(std::abs(component) == Approx(0.5 * std::sin(x) / x * line).epsilon(1e-4));
  CHECK(std::remainder(std::arg(component) + std::numbers::pi / 2 + 2 * std::numbers::pi * 125 * 0.0025,
                       2 * std::numbers::pi) == Approx(0.0).margin(2 * std::numbers::pi * 125 * 2.1e-5));
}

#endif

TEST_CASE("two devices: when the first brings no blocks, outputs of the second come to zero in steps") {
  Desk desk;
  desk.probe.out = [](int channel, std::int64_t) { return channel == 1 ? 0.8 : 0.0; };
  desk.open();
  double level = 0.0;
  for (int n = 0; n < 400; ++n, desk.seconds += kBlock / kRate_hz) {
    desk.play();
    level = desk.poll(0, 0)[0];
  }
  CHECK(level == Approx(0.8).margin(1e-6));
  int steps = 0;
  for (const double stopped = desk.seconds; level > 0; ++steps) {
    desk.seconds += kPoll_s;
    const double next = desk.poll(0, 0)[0];
    CHECK(level - next <= 0.1 + 1e-12);
    if (desk.seconds < stopped + 0.02) CHECK(next == Approx(0.8).margin(1e-6));
    level = next;
  }
  CHECK(steps == Approx(20 + 8).margin(4));  // 20 ms of patience and eight steps
}

TEST_CASE("two devices: the stream is lost with either, and says which") {
  Desk desk;
  desk.open();
  CHECK(desk.stream->state() == StreamState::Running);
  desk.pad_world.state = StreamState::Lost;
  CHECK(desk.stream->state() == StreamState::Lost);
  CHECK(desk.stream->take_note() == "the second device, 'fake:pad', was disconnected");
  CHECK(desk.stream->take_note().empty());
  desk.pad_world.state = StreamState::Running;
  desk.card_world.state = StreamState::Stalled;
  CHECK(desk.stream->state() == StreamState::Stalled);
}

TEST_CASE("two devices: a stream without channels of the second is that of the first") {
  Desk desk{{0, 1}};
  desk.open();
  CHECK_FALSE(desk.stream->granted().second);
  CHECK(desk.pad_world.requests.empty());
}

TEST_CASE("two devices: other writers are reported by the channel of the processor") {
  Desk desk;
  desk.card_world.writers = {{1, "other:out", "card:playback_7"}};
  desk.open();
  CHECK(desk.stream->other_writers().front().output == 3);
}

TEST_CASE("two devices: a request without channels of the first is refused") {
  Desk desk{{kSecondDevice, kSecondDevice + 1}};
  const auto opened = desk.both->open(desk.request, desk.guarded);
  REQUIRE_FALSE(opened);
  CHECK(opened.error().remedy == "make 'fake:pad' the output device");
}
