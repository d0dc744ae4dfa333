#include "latency/measurement.h"

#include <catch2/catch.hpp>

#include "backends/jack/jack.h"
#include "tests/cards/ways.h"

using namespace tactus;
using test::every_way;
using test::start_card;

namespace {

constexpr int kPeriod = 256;

/// One opening of two sweeps: they last as long as they last.
Measurement measured(Backend& backend, StreamRequest request) {
  MeasureSettings settings;
  settings.request = std::move(request);
  settings.input = settings.output = 1;
  settings.guard = {DriveGuard::Kind::Audio, {}};
  settings.openings = 1;
  settings.sweeps = 2;
  auto measurement = measure(backend, settings);
  REQUIRE(measurement);
  return std::move(*measurement);
}

void check_delay(const Measurement& measurement, double frames) {
  const auto& opening = measurement.openings.front();
  CAPTURE(measurement.finding.what, opening.health.xruns, opening.level_dbfs);
  if (opening.health.xruns > 0) return;  // a busy machine
  CHECK(code(measurement.finding.verdict) == std::string{"ok"});
  CHECK(measurement.delay_frames == Approx(frames).margin(0.01));
}

}  // namespace

TEST_CASE("measurement: through every library the delay is the card's and two periods", "[cards]") {
  const auto rig = start_card({.delay_frames = 960.25, .noise = 3e-5});
  if (!rig) return;
  JackBackend jack;
  auto request = rig->request(every_way().front(), 0, 0);
  request.device = "jack:" + rig->card->name();
  check_delay(measured(jack, request), 960.25 + kPeriod);
  for (const auto& way : every_way()) {
    CAPTURE(way.name);
    const auto backend = way.backend();
    const auto of_way = rig->request(way, 0, 0);
    const auto measurement = measured(*backend, of_way);
    if (!way.alsa) check_delay(measurement, 960.25 + 2 * kPeriod);
    CHECK(measurement.finding.verdict != Verdict::ApiMismatch);
  }
}
