#include <catch2/catch.hpp>
#include <cmath>

#include "tests/latency/simulated_cards.h"
#include "tests/support/error_summary.h"

// What a measurement says against itself.

using namespace tactus;
using test::expect;
using test::measured;
using test::named;
using test::on_a_wire;

TEST_CASE("measurement: what goes wrong is said, with what to do", "[latency][measurement]") {
  struct Case {
    const char* card;
    Verdict verdict;
  };
  const auto each = GENERATE(
      Case{"no_cable", Verdict::NoSignal}, Case{"wrong_channel", Verdict::WrongChannel},
      Case{"howl", Verdict::Feedback}, Case{"clipping", Verdict::Clipping}, Case{"dc=1", Verdict::Clipping},
      Case{"gain=40dB,noise=-40dB,clip=0.1", Verdict::Clipping}, Case{"drops", Verdict::LostFrames},
      Case{"wrong_rate", Verdict::ApiMismatch}, Case{"wrong_block", Verdict::ApiMismatch},
      Case{"drift", Verdict::ClocksDiffer}, Case{"echo_cancel", Verdict::EchoCancel},
      Case{"agc", Verdict::Agc}, Case{"monitor", Verdict::DirectMonitoring}, Case{"noise", Verdict::LowSnr});
  CAPTURE(each.card);
  expect(measured({named(each.card)}), each.verdict);
}

TEST_CASE("measurement: frames that are lost count although the driver is silent about them",
          "[latency][measurement]") {
  auto card = named("20ms");
  card.drops = {{Seconds{3.0}, Seconds{0.0}, GENERATE(5, -5)}};
  card.drops_reported = false;
  expect(measured({card}), Verdict::LostFrames);
}

TEST_CASE("measurement: a gap that the driver tells counts although nothing is missing",
          "[latency][measurement]") {
  auto card = named("20ms");
  card.drops = {{Seconds{3.0}, Seconds{0.0}, 0}};
  expect(measured({card}), Verdict::LostFrames);
}

TEST_CASE("measurement: a gap that the driver reports is no clipping, though it has harmonics too",
          "[latency][measurement]") {
  auto card = named("gain=40dB,noise=-40dB,clip=0.1");
  card.drops = {{Seconds{3.0}, Seconds{0.0}, 0}};
  expect(measured({card}), Verdict::LostFrames);
}

TEST_CASE("measurement: gaps before the sweeps are none", "[latency][measurement]") {
  auto card = named("20ms");
  card.drops = {{Seconds{0.05}, Seconds{0.0}, 100}, {Seconds{0.1}, Seconds{0.0}, -100}};
  const auto measurement = measured({card});
  CHECK(code(measurement.finding.verdict) == std::string{"ok"});
  CHECK(measurement.openings.front().health.xruns == 2);
}

TEST_CASE("measurement: one opening of five may lose frames, two of four may not", "[latency][measurement]") {
  const auto good = named("20ms"), bad = named("drops");
  const auto one_bad = measured({good, bad, good, good}, on_a_wire(4));
  CHECK(code(one_bad.finding.verdict) == std::string{"ok"});
  CHECK(test::names_in(one_bad.finding.what) == "1 4");
  CHECK(one_bad.delay_frames == Approx(960.0).epsilon(0).margin(1e-3));
  expect(measured({good, bad, bad, good}, on_a_wire(4)), Verdict::LostFrames);
}

TEST_CASE("measurement: a start that is unstable is reported with every delay", "[latency][measurement]") {
  auto card = named("20ms");
  auto later = card;
  later.delay_frames = 0.6;
  const auto moved = measured({card, later, card}, on_a_wire(3));
  expect(moved, Verdict::UnstableStart);
  CHECK(test::names_in(moved.finding.what).ends_with("960.000 960.600 960.000"));
  CHECK(moved.spread_frames == Approx(0.6 / std::sqrt(3.0)).epsilon(0).margin(1e-3));
  later.delay_frames = 0.4;
  CHECK(code(measured({card, later, card}, on_a_wire(3)).finding.verdict) == std::string{"ok"});
}

TEST_CASE("measurement: a second arrival is traced to the card or to a connection by another block",
          "[latency][measurement]") {
  CHECK(test::names_in(measured({named("monitor")}).finding.what).ends_with("201 64 201 128"));
  CHECK(test::names_in(measured({named("software_monitor")}).finding.what).ends_with("329 64 457 128"));
}

TEST_CASE("measurement: what the guard attenuates is measured, and no feedback", "[latency][measurement]") {
  auto settings = on_a_wire();
  settings.guard.kind = DriveGuard::Kind::Drive;
  settings.guard.limits.excursion = ExcursionLimits{1e-7, 1e-3, 40_Hz, 1.0};
  const auto measurement = measured({named("20ms")}, settings);
  CHECK(code(measurement.finding.verdict) == std::string{"ok"});
  CHECK(measurement.delay_frames == Approx(960).epsilon(0).margin(0.01));
}
