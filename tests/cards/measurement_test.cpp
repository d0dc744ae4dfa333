#include "latency/measurement.h"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/cards/jack_delay.h"
#include "tests/cards/ways.h"
#include "tests/support/error_summary.h"
#include "tests/support/undisturbed.h"

// What the delay is, is known here: a card that is a JACK client, on a server whose clock never drifts.

using namespace tactus;
using test::CardOnServer;
using test::DelayClient;
using test::every_way;
using test::start_card;
using test::Way;

namespace {

constexpr int kPeriod = 1024;  // [frames] of the server: a virtual machine pauses for longer than short ones
constexpr double kMargin = 0.001;    // frames
constexpr double kPrinted = 0.0005;  // what jack_delay leaves off
constexpr double kTheirRange = 65536;
constexpr int kReadings = 9;  // of jack_delay, while ours is measured

StreamRequest request_for(const std::string& device, std::optional<int> block = kPeriod) {
  StreamRequest request;
  request.device = device;
  request.block_frames = block;
  request.client_name = "tactus-" + std::to_string(::getpid());
  return request;
}

Measurement measured_once(Backend& backend, const StreamRequest& request) {
  auto measurement = measure(backend, test::short_measurement(request));
  REQUIRE(measurement);
  return std::move(*measurement);
}

/// Frames that a busy machine loses are reported; only a measurement without them can have the right delay.
Measurement measured(Backend& backend, const StreamRequest& request) {
  return test::undisturbed("frames were lost", [&]() -> std::optional<Measurement> {
    auto measurement = measured_once(backend, request);
    if (measurement.finding.verdict != Verdict::LostFrames) return measurement;
    const auto& health = measurement.openings.front().health;
    CAPTURE(measurement.finding.what);
    REQUIRE(health.xruns + health.lost_frames > 0);
    return std::nullopt;
  });
}

double checked_delay(const Measurement& measurement) {
  const auto& opening = measurement.openings.front();
  CAPTURE(measurement.finding.what, opening.health.xruns, opening.level_dbfs);
  CHECK(code(measurement.finding.verdict) == std::string{"ok"});
  // So it is no luck. (The standard error of three probes scatters too much to be compared.)
  CHECK(kMargin > 5 * opening.analysis.bound_frames);
  return measurement.delay_frames;
}

/// Ours on the first channel of a card, theirs on the second one at the same time.
void check_beside_jack_delay(test::SoundServer& server, const DelayClient::Settings& settings) {
  CAPTURE(settings.delay_frames, settings.gain, settings.noise);
  const DelayClient card{settings};
  const auto theirs = start_jack_delay(server, card.name() + ":playback_2", card.name() + ":capture_2");
  const auto jack = test::backend_named("jack");
  const auto measurement = measured(*jack, request_for("jack:" + card.name()));
  const double ours = checked_delay(measurement), right = settings.delay_frames + kPeriod;
  CHECK_THAT(ours, Catch::WithinAbs(right, kMargin));
  CHECK(measurement.openings.front().analysis.polarity == (settings.gain < 0.0 ? -1 : 1));
  if (!theirs) return;
  const double read = theirs->frames(kReadings), short_by = right < kTheirRange ? 0.0 : kTheirRange;
  CHECK_THAT(read, Catch::WithinAbs(ours - short_by, kMargin + kPrinted));
}

/// Through a library.
void check_way(const Way& way, const std::string& client, std::optional<int> block, double frames) {
  CAPTURE(way.name, client, block.value_or(0));
  const auto backend = way.backend();
  const auto measurement = measured(*backend, request_for(way.name + ":" + client, block));
  CHECK_THAT(checked_delay(measurement), Catch::WithinAbs(frames, kMargin));
}

/// JACK, with a card that leaves before the second opening, and one of the same name that comes.
class ReplacingBackend final : public Backend {
 public:
  explicit ReplacingBackend(std::optional<DelayClient::Settings> second) : second_(std::move(second)) {}
  std::string name() const override { return jack_->name(); }
  Result<std::vector<Device>> devices() override { return jack_->devices(); }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    if (++opened == 2 && second_) {
      card.reset();
      card = std::make_unique<DelayClient>(*second_);
    }
    return jack_->open(request, processor);
  }

  std::unique_ptr<DelayClient> card = std::make_unique<DelayClient>();
  int opened = 0;

 private:
  std::unique_ptr<Backend> jack_ = test::backend_named("jack");
  std::optional<DelayClient::Settings> second_;
};

}  // namespace

TEST_CASE("measurement: the delay of a real server is right to a thousandth of a frame, as jack_delay says",
          "[cards]") {
  const auto server = test::start_sound_server({.period = kPeriod});
  for (const double delay : {0.0, 100.0, 960.0, 960.25})
    check_beside_jack_delay(*server, {.delay_frames = delay});
}

TEST_CASE("measurement: it is where jack_delay is a turn of 65,536 frames short, too", "[cards][slow]") {
  const auto server = test::start_sound_server({.period = kPeriod});
  for (const double delay : {65600.25, 70000.0}) check_beside_jack_delay(*server, {.delay_frames = delay});
}

TEST_CASE("measurement: neither a gain of -60 dB nor inversion nor noise changes the delay",
          "[cards][slow]") {
  const auto server = test::start_sound_server({.period = kPeriod});
  check_beside_jack_delay(*server, {.delay_frames = 960.25, .gain = 0.001});
  check_beside_jack_delay(*server, {.delay_frames = 960.25, .gain = -0.5});
  // With twice as much noise the bound itself is beyond a fifth of the margin.
  check_beside_jack_delay(*server, {.delay_frames = 960.25, .noise = 0.005});
}

TEST_CASE("measurement: libraries over JACK add a period, unless the block is left to them",
          "[cards][slow]") {
  const auto rig = start_card({.delay_frames = 960.25}, {.period = kPeriod});
  for (const auto& way : every_way()) {
    if (way.alsa) continue;
    check_way(way, rig->card->name(), kPeriod, 960.25 + 2 * kPeriod);
    check_way(way, "loopback", kPeriod, 2 * kPeriod);
    if (way.name == "portaudio:jack") check_way(way, "loopback", std::nullopt, kPeriod);
  }
}

TEST_CASE("measurement: over ALSA the delay is the card's and whole periods", "[cards][slow]") {
  const auto rig = start_card({.delay_frames = 960.25}, {.period = kPeriod});
  for (const auto& way : every_way()) {
    if (!way.alsa) continue;
    CAPTURE(way.name);
    const auto backend = way.backend();
    const double delay = checked_delay(measured(*backend, rig->request(way, 0, 0)));
    const double periods = std::round((delay - 960.25) / kPeriod);
    CHECK(periods >= 1);  // how many, differs after gaps
    CHECK_THAT(delay, Catch::WithinAbs(960.25 + periods * kPeriod, kMargin));
  }
}

TEST_CASE("measurement: with another program at the output's port nothing is measured", "[cards]") {
  const auto on_server = start_card();
  const auto jack = test::backend_named("jack");
  auto settings = test::short_measurement(request_for("jack:" + on_server->card->name()));
  const auto out = on_server->card->name() + ":playback_1";
  on_server->server->connect("system:capture_1", out);  // silence
  const auto refused = measure(*jack, settings);
  REQUIRE_FALSE(refused);
  CHECK(test::summary(refused) ==
        settings.request.device + " Device 'system:capture_1' '" + out + "' --shared-port");
  settings.shared_port = true;
  CHECK(measure(*jack, settings));
}

TEST_CASE("measurement: it ends when another JACK client has the name of the card at the next opening",
          "[cards][slow]") {
  const auto server = test::start_sound_server({.period = kPeriod});
  const auto result_with = [](std::optional<DelayClient::Settings> second) {
    ReplacingBackend backend{std::move(second)};
    auto settings = test::short_measurement(request_for("jack:" + backend.card->name()));
    settings.openings = 2;
    auto result = measure(backend, settings);
    CHECK(backend.opened == 2);
    return result;
  };
  CHECK(result_with({}));
  for (const auto& second :
       {DelayClient::Settings{}, DelayClient::Settings{.channels = 4, .reversed = true}}) {
    CAPTURE(second.channels);
    const auto refused = result_with(second);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == Errc::Device);
    CHECK(refused.error().what.find("left its server and came back") != std::string::npos);
  }
}
