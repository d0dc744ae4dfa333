#include <catch2/catch.hpp>
#include <complex>
#include <numbers>

#include "engine/dsp/pitch/pitch_detector.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;

namespace {

/// A plucked comb: the loop lasts 1 / pitch, filters included.
std::string comb(const std::string& filter, const std::string& gain, const std::string& pitch) {
  return "format = 1\nname = \"test\"\n[inputs]\nx = {}\n"
         "[controls]\npitch = { " +
         pitch + " }\n[nodes]\nloss = { " + filter +
         ", in = \"line\" }\n"
         "line = { type = \"delay\", in = \"x + " +
         gain +
         " * loss\", time = \"1 / pitch\", compensate = [\"loss\"] }\n"
         "[outputs]\ny = { from = \"line\" }\n";
}

/// Frequency of the partial next to `near`: how far its phase turns in 0.1 s, seen through Hann windows of
/// 0.5 s. They let 1e-5 of a partial at 110 Hz distance through: 1e-5 rad in 69, 1e-7 of the frequency.
double partial(const test::Samples& y, std::size_t from, double near) {
  constexpr std::size_t kWindow = 24000, kShift = 4800;
  const auto seen = [&](std::size_t start) {
    std::complex<double> sum = 0;
    for (std::size_t n = 0; n < kWindow; ++n) {
      const double hann = 1 - std::cos(2 * std::numbers::pi * static_cast<double>(n) / kWindow);
      sum += hann * y[start + n] *
             std::polar(1.0, -2 * std::numbers::pi * near / 48000 * static_cast<double>(start + n));
    }
    return sum;
  };
  return near + std::arg(seen(from + kShift) / seen(from)) / (2 * std::numbers::pi * kShift / 48000.0);
}

test::Samples pluck(Player& engine) { return test::run(engine, {test::impulse(48000)}, 48000, {256})[0]; }

const std::string kOnePole = "type = \"one_pole\", cutoff = \"6 * pitch\"";

/// Where the loop sounds when nothing is taken off: f / pitch + phi(f) / 2 pi = 1, with the phase phi of the
/// one_pole above.
double untuned(double pitch) {
  const auto warped = [](double f) { return std::tan(std::numbers::pi * f / 48000); };
  double f = pitch;
  for (int i = 0; i < 50; ++i)
    f = pitch * (1 - std::atan(warped(f) / warped(6 * pitch)) / (2 * std::numbers::pi));
  return f;
}

}  // namespace

TEST_CASE("compensate: a loop with a filter in it is in tune", "[runtime]") {
  for (const double pitch : {110.0, 440.0, 1760.0}) {
    const auto fixed = "value = \"" + std::to_string(pitch) + " Hz\"";
    const auto ranged = fixed + ", range = [\"100 Hz\", \"2 kHz\"]";
    INFO(pitch);
    const auto engine = test::engine_of(comb(kOnePole, "0.999", ranged));
    CHECK(std::abs(cents(partial(pluck(*engine), 4800, pitch), pitch)) < 0.5);
    for (const auto& node : engine->plan().nodes) CHECK(node->clamped() == 0);
    auto plain = comb(kOnePole, "0.999", ranged);
    plain.erase(plain.find(", compensate"), std::string{", compensate = [\"loss\"]"}.size());
    const double flat = partial(pluck(*test::engine_of(plain)), 4800, untuned(pitch));
    CHECK(std::abs(cents(flat, untuned(pitch))) < 0.5);
    CHECK(cents(flat, pitch) < -30);
  }
}

TEST_CASE("compensate: a loop stays in tune when its pitch moves", "[runtime]") {
  for (const double pitch : {110.0, 440.0, 1760.0}) {
    INFO(pitch);
    const auto engine =
        test::engine_of(comb(kOnePole, "0.999", "value = \"300 Hz\", range = [\"100 Hz\", \"2 kHz\"]"));
    engine->set_journal({{1001, JournalEntry::Kind::ControlChange, 0, pitch}});
    CHECK(std::abs(cents(partial(pluck(*engine), 4800, pitch), pitch)) < 0.5);
    for (const auto& node : engine->plan().nodes) CHECK(node->clamped() == 0);
  }
}

TEST_CASE("compensate: a filter whose phase leads lengthens the delay", "[runtime]") {
  const auto engine = test::engine_of(comb("type = \"high_pass\", cutoff = \"40 Hz\", q = 0.7", "0.99",
                                           "value = \"440 Hz\", range = [\"440 Hz\", \"441 Hz\"]"));
  CHECK(std::abs(cents(partial(pluck(*engine), 4800, 440), 440)) < 0.5);
  for (const auto& node : engine->plan().nodes) CHECK(node->clamped() == 0);
}

TEST_CASE("compensate: several filters at once, and the sub-block stays within what is left", "[runtime]") {
  auto text = comb(kOnePole, "0.999", "value = \"440 Hz\", range = [\"400 Hz\", \"500 Hz\"]");
  text.replace(text.find("x + 0.999 * loss"), 16, "x + 0.999 * more");
  text.replace(text.find("[\"loss\"]"), 8, "[\"loss\", \"more\"]");
  text.replace(text.find("[nodes]"), 7,
               "[nodes]\nmore = { type = \"one_pole\", cutoff = \"3 kHz\", in = \"loss\" }");
  const auto engine = test::engine_of(text);
  CHECK(std::abs(cents(partial(pluck(*engine), 4800, 440), 440)) < 0.5);
  REQUIRE(engine->plan().loops.size() == 1);
  // 48000 / 500 = 96 frames, less 1.5 and 2.5 of the filters and 1 of the interpolator.
  CHECK(engine->plan().loops[0].delay_frames <= 91);
  CHECK(engine->plan().loops[0].delay_frames >= 89);
}

TEST_CASE("compensate: a node whose phase is not known is refused", "[runtime]") {
  const auto range = "value = \"440 Hz\", range = [\"400 Hz\", \"500 Hz\"]";
  CHECK(test::errors_of(comb("type = \"quantiser\", step = 0.1", "0.5", range)) ==
        "test.toml:9:1 BadArgument 'loss'");
  CHECK(test::errors_of(comb("type = \"mix\"", "0.5", range)) == "test.toml:9:1 BadArgument 'loss.out'");
}
