#include "latency/estimation/analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "engine/core/index.h"
#include "engine/dsp/delays/resample.h"
#include "latency/estimation/delay_trend.h"
#include "latency/probe/probe.h"
#include "tests/support/error_summary.h"
#include "tests/support/simulated_loop.h"

namespace {

using namespace tactus;
using test::SimulatedLoop;

constexpr double kLevel = 0.25;

const std::vector<double>& probe() {
  static const auto samples = stimulus(48_kHz, kLevel);
  return samples;
}

Analysis analysis_of(const LoopRecording& recording, int channel = 0) {
  AnalysisSettings settings;
  settings.channel = channel;
  const auto analysis = analyze(recording, settings);
  REQUIRE(analysis);
  return *analysis;
}

Analysis analysis_of(const SimulatedLoop& loop) { return analysis_of(loop.record(probe(), 48_kHz)); }

/// Mean square of a sweep at full level.
double sweep_power() {
  double sum = 0.0;
  const auto sweep = measuring_probe(48_kHz).samples(48_kHz);
  for (const double sample : sweep)
    sum += kLevel * kLevel * sample * sample / static_cast<double>(sweep.size());
  return sum;
}

double noise_for(double snr_db, double gain = 1.0) {
  return std::abs(gain) * std::sqrt(sweep_power() * std::pow(10.0, -snr_db / 10.0));
}

/// `samples` with white, normal noise of that rms.
std::vector<double> noisy(std::vector<double> samples, double noise) {
  std::mt19937_64 random{7};
  std::normal_distribution<double> normal;
  for (auto& sample : samples) sample += noise * normal(random);
  return samples;
}

std::string verdict(const Analysis& analysis) { return code(analysis.finding.verdict); }

}  // namespace

TEST_CASE("analysis: a flat path's delay, gain and polarity are what they are", "[latency]") {
  const auto [delay, gain] = GENERATE(
      table<double, double>({{0.0, 1.0}, {0.3, 0.5}, {960.25, -0.1}, {65536.5, 1.0}, {199999.7, -0.001}}));
  const auto analysis = analysis_of({.delay_frames = delay, .gain = gain});
  CHECK(verdict(analysis) == "ok");
  CHECK(analysis.delay_frames == Approx(delay).epsilon(0).margin(1e-5));
  CHECK(analysis.gain_db == Approx(20 * std::log10(std::abs(gain))).epsilon(0).margin(0.001));
  CHECK(analysis.polarity == (gain < 0 ? -1 : 1));
  CHECK(std::abs(analysis.drift_ppm) < 0.001);
  CHECK(analysis.low_hz < 21.0);
  CHECK(analysis.high_hz == Approx(0.42 * 48000).epsilon(0.06));
}

TEST_CASE("analysis: the error is that of the Cramér-Rao bound, and the standard error says so",
          "[latency][slow]") {
  const double snr = GENERATE(0.0, 20.0);
  constexpr int kTrials = 16;
  double squares = 0.0, stated = 0.0, bound = 0.0;
  for (int n = 0; n < kTrials; ++n) {
    const SimulatedLoop loop{
        .delay_frames = 700.0 + 17.37 * n, .noise = noise_for(snr), .seed = 100u + static_cast<unsigned>(n)};
    const auto analysis = analysis_of(loop);
    squares += std::pow(analysis.delay_frames - loop.delay_frames, 2) / kTrials;
    stated += std::pow(analysis.standard_error_frames, 2) / kTrials;
    bound = analysis.bound_frames;
    CHECK(analysis.snr_db == Approx(snr).epsilon(0).margin(0.6));
  }
  // The rms of 16 normal errors is within 0.6 and 1.45 of their deviation in 99 of 100 cases.
  CHECK(std::sqrt(squares) < 1.45 * bound);
  CHECK(std::sqrt(squares) > 0.6 * bound);
  CHECK(std::sqrt(stated) == Approx(bound).epsilon(0.35));
}

TEST_CASE("analysis: coupling capacitors change the delay by no more than the noise does", "[latency]") {
  // 2 corners of 30 Hz: their own delay at 150 Hz is 40 frames.
  const auto corners =
      GENERATE(std::vector<double>{4.0}, std::vector<double>{30.0}, std::vector<double>{30.0, 30.0});
  const auto analysis =
      analysis_of({.delay_frames = 960.25, .high_pass_hz = corners, .noise = noise_for(40.0)});
  CHECK(verdict(analysis) == "ok");
  CHECK(analysis.delay_frames == Approx(960.25).epsilon(0).margin(0.0005));
  CHECK(analysis.high_pass_hz ==
        Approx(corners[0] * static_cast<double>(corners.size())).epsilon(0).margin(2.0));
}

TEST_CASE("analysis: the corners of high-passes add up, and lie within the stated error", "[latency]") {
  const double corner = GENERATE(1.0, 5.0, 10.0, 20.0);
  const int poles = GENERATE(1, 2);  // output alone; output and input
  const double snr_db = GENERATE(40.0, 80.0);
  CAPTURE(corner, poles, snr_db);
  const auto analysis =
      analysis_of({.delay_frames = 960.25,
                   .high_pass_hz = std::vector<double>(static_cast<std::size_t>(poles), corner),
                   .noise = noise_for(snr_db)});
  REQUIRE(analysis.high_pass_error_hz);
  CHECK(std::abs(analysis.high_pass_hz - poles * corner) < 4 * *analysis.high_pass_error_hz);
  // At 80 dB the noise hides a hundredth of what it hides at 40 dB; the series of the model hides
  // S (S / 150 Hz)^4.
  const double sum = poles * corner;
  CHECK(*analysis.high_pass_error_hz < (snr_db > 60 ? 0.02 : 2.0) + 2 * sum * std::pow(sum / 150, 4));
  CHECK(analysis.fitted_from_hz == Approx(150).margin(1));
}

TEST_CASE("analysis: without a high-pass none stands out of the error", "[latency]") {
  const auto analysis = analysis_of({.delay_frames = 960.25, .noise = noise_for(60.0)});
  REQUIRE(analysis.high_pass_error_hz);
  CHECK(analysis.high_pass_hz < 4 * *analysis.high_pass_error_hz);
}

TEST_CASE("analysis: DC and hum are distinguished from what was played", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 960.25, .gain = 0.1, .noise = 1e-5}.record(probe(), 48_kHz);
  for (std::size_t n = 0; n < recording.captured[0].size(); ++n)
    recording.captured[0][n] +=
        0.05 + 0.1 * std::sin(2 * std::numbers::pi * 50.0 / 48000.0 * static_cast<double>(n));
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "ok");
  CHECK(analysis.dc == Approx(0.05).epsilon(0).margin(1e-4));
  CHECK(analysis.noise_floor_dbfs == Approx(20 * std::log10(0.1) - 3.01).epsilon(0).margin(0.05));
  CHECK(analysis.delay_frames == Approx(960.25).epsilon(0).margin(0.0005));
}

TEST_CASE("analysis: DC that is far louder than the probe is no lost frame", "[latency]") {
  const double gain = GENERATE(0.2, 0.05, 0.02), corner = GENERATE(10.0, 30.0);
  auto recording =
      SimulatedLoop{.delay_frames = 960.25, .gain = gain, .high_pass_hz = {corner}, .noise = gain * 1e-3}
          .record(probe(), 48_kHz);
  for (auto& x : recording.captured[0]) x += 0.1;
  const auto analysis = analysis_of(recording);
  CAPTURE(gain, corner, analysis.finding.what);
  CHECK(verdict(analysis) == "ok");
  CHECK(analysis.dc == Approx(0.1).epsilon(1e-3));
}

TEST_CASE("analysis: 50 ppm of drift are found within 1 ppm, and the delay in the middle is right",
          "[latency]") {
  const double ppm = GENERATE(50.0, -50.0, 3.0, 400.0);
  auto recording = SimulatedLoop{.delay_frames = 960.25}.record(probe(), 48_kHz);
  recording.captured[0] = at_speed(recording.captured[0], 1.0 / (1.0 + 1e-6 * ppm));
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "CLOCKS_DIFFER");
  CHECK(analysis.drift_ppm == Approx(ppm).epsilon(0).margin(0.01));
  // What was played at t is captured at (t + 960.25)(1 + ppm).
  const double middle =
      0.5 * static_cast<double>(analysis.probes.front().played_at + analysis.probes.back().played_at + 16800);
  // Where a sweep begins is known within 100 frames: its first ones are too soft.
  const double expected = (middle + 960.25) * (1 + 1e-6 * ppm) - middle;
  CHECK(std::abs(analysis.delay_frames - expected) < 0.0005 + 1e-4 * std::abs(ppm));
}

TEST_CASE("analysis: harmonics are those of the polynomial that makes them", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 960.25}.record(probe(), 48_kHz);
  for (auto& x : recording.captured[0]) x += 0.1 * x * x + 0.2 * x * x * x;
  const auto analysis = analysis_of(recording);
  // a sine of 0.25: x² gives 0.1 * 0.25 / 2 of it at 2 f; x³ gives 0.2 * 0.25² / 4 at 3 f and 3 times that at
  // f
  const double fundamental = 1.0 + 3.0 * 0.2 * 0.0625 / 4.0;
  REQUIRE(analysis.harmonics_db[0]);
  REQUIRE(analysis.harmonics_db[1]);
  CHECK(*analysis.harmonics_db[0] ==
        Approx(20 * std::log10(0.1 * 0.125 / fundamental)).epsilon(0).margin(0.2));
  CHECK(*analysis.harmonics_db[1] ==
        Approx(20 * std::log10(0.2 * 0.0625 / 4.0 / fundamental)).epsilon(0).margin(0.2));
  CHECK(analysis.harmonics_db[2].value_or(-200.0) < -90.0);
}

TEST_CASE("analysis: group delay by octave is that of the high pass", "[latency]") {
  const auto analysis =
      analysis_of({.delay_frames = 100.0, .high_pass_hz = {30.0}, .noise = noise_for(60.0)});
  for (const auto& octave : analysis.group_delay) {
    if (octave.centre_hz < 100.0) continue;  // there it bends within the octave
    // phase atan(fc / f): -dφ/dω = fc / (2π (f² + fc²)), here at the octave's centre
    const double f = octave.centre_hz;
    const double expected = 100.0 + 48000.0 * 30.0 / (2 * std::numbers::pi * (f * f + 900.0));
    CHECK(octave.delay_frames == Approx(expected).epsilon(0.02).margin(6.0 * octave.standard_error_frames));
  }
  CHECK(analysis.group_delay.size() >= 9);
}

TEST_CASE("analysis: nothing is detected where there is nothing", "[latency]") {
  auto recording = SimulatedLoop{.gain = 0.0, .noise = 1e-3, .bits = 16}.record(probe(), 48_kHz);
  const auto what = GENERATE(as<std::string>{}, "noise", "silence", "tone", "click", "DC");
  auto& captured = recording.captured[0];
  if (what == "click") captured[100000] = 0.5;
  if (what != "noise" && what != "click")
    std::fill(captured.begin(), captured.end(), what == "DC" ? 0.3 : 0.0);
  if (what == "tone")
    for (std::size_t n = 0; n < captured.size(); ++n)
      captured[n] = 0.01 * std::sin(0.1 * static_cast<double>(n));
  CAPTURE(what);
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "NO_SIGNAL");
  CHECK_FALSE(analysis.detected);
  CHECK(analysis.finding.remedy.find("cable") != std::string::npos);
}

TEST_CASE("analysis: a signal on another input is found there", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 500.0, .noise = 1e-4}.record(probe(), 48_kHz);
  recording.captured.insert(
      recording.captured.begin(),
      SimulatedLoop{.gain = 0.0, .noise = 1e-4, .seed = 5}.record(probe(), 48_kHz).captured[0]);
  recording.captured[0].resize(recording.captured[1].size());
  const auto analysis = analysis_of(recording, 0);
  CHECK(verdict(analysis) == "WRONG_CHANNEL");
  CHECK(analysis.finding.what.find("on input 2") != std::string::npos);
  CHECK(verdict(analysis_of(recording, 1)) == "ok");
}

TEST_CASE("analysis: lost, repeated and silenced frames are found where they are", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 960.25, .gain = 0.5, .noise = 1e-4}.record(probe(), 48_kHz);
  auto& captured = recording.captured[0];
  const auto at = [&](int frame) { return captured.begin() + frame; };
  SECTION("lost between sweeps") {
    captured.erase(at(88000), at(88064));
    captured.resize(recording.played.size());
    const auto analysis = analysis_of(recording);
    CHECK(verdict(analysis) == "LOST_FRAMES");
    REQUIRE(analysis.steps.size() == 1);
    CHECK(analysis.steps[0].frames == Approx(-64.0).epsilon(0).margin(0.01));
  }
  SECTION("repeated in the pilot") {
    const std::vector<double> again(at(215000), at(215128));
    captured.insert(at(215128), again.begin(), again.end());
    captured.resize(recording.played.size());
    const auto analysis = analysis_of(recording);
    CHECK(verdict(analysis) == "LOST_FRAMES");
    REQUIRE(analysis.steps.size() == 1);
    CHECK(analysis.steps[0].frames == Approx(128.0).epsilon(0).margin(0.01));
    CHECK(analysis.steps[0].frame == Approx(215128 - 960).epsilon(0).margin(2048));
  }
  SECTION("silenced in a sweep") {
    std::fill(at(100000), at(100256), 0.0);
    const auto analysis = analysis_of(recording);
    CHECK(verdict(analysis) == "LOST_FRAMES");
    REQUIRE(analysis.steps.size() == 1);
    CHECK(analysis.steps[0].frames == 0.0);
    CHECK(analysis.steps[0].frame == Approx(100000 - 960).epsilon(0).margin(128));
  }
}

TEST_CASE("analysis: frames lost within the first sweep are reported, too", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 1234.37, .noise = 1e-3}.record(probe(), 48_kHz);
  auto& captured = recording.captured[0];
  const int at = GENERATE(38000, 41000);  // 0.27 and 0.33 s into it
  const int frames = GENERATE(1, 2, 16);
  captured.erase(captured.begin() + at, captured.begin() + at + frames);
  captured.resize(recording.played.size());
  CHECK(verdict(analysis_of(recording)) == "LOST_FRAMES");
}

TEST_CASE("analysis: the steps of a converter are noise, although silence has none", "[latency]") {
  const double gain = GENERATE(0.1, 0.01, 0.001);
  const auto analysis = analysis_of({.delay_frames = 1234.37, .gain = gain, .bits = 16});
  CHECK(verdict(analysis) == "ok");
  CHECK(std::abs(analysis.delay_frames - 1234.37) < 0.0005);
  CHECK(analysis.snr_db ==
        Approx(10 * std::log10(gain * gain * sweep_power() * 12.0 * 0x1p30)).epsilon(0).margin(3.0));
}

TEST_CASE("analysis: a probe with dither in its pauses is taken apart all the same", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 1234.37, .noise = 1e-4}.record(probe(), 48_kHz);
  std::uint32_t random = 1;
  for (auto& sample : recording.played) {
    random = random * 1664525u + 1013904223u;
    sample += static_cast<double>(random >> 8) * 0x1p-24 * 0x1p-15;
  }
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "ok");
  CHECK(analysis.probes.size() == ProbeTrain::kProbes);
  CHECK(std::abs(analysis.delay_frames - 1234.37) < 0.0005);
}

TEST_CASE("analysis: a recording may have a higher rate than its probe", "[latency]") {
  const auto [from, to, noise] = GENERATE(table<double, double, double>({{16000, 32000, 1e-6},
                                                                         {16000, 48000, 1e-6},
                                                                         {48000, 192000, 1e-6},
                                                                         {48000, 192000, 1e-4},
                                                                         {8000, 48000, 1e-6},
                                                                         {8000, 48000, 1e-4}}));
  CAPTURE(from, to, noise);
  const auto slow = stimulus(Hertz{from}, kLevel);
  const auto times = static_cast<int>(to / from);
  const auto frames = std::ssize(slow) * times;
  LoopRecording recording;
  recording.sample_rate = Hertz{to};
  recording.played = resample(slow, Hertz{from}, Hertz{to}, 0, frames);
  // What is captured of a card that plays at the lower rate: all of each frame's wave, also before the first.
  auto captured = resample(slow, Hertz{from}, Hertz{to}, -3000 * times, frames + 12000 * times);
  for (auto& sample : captured) sample *= 0.5;
  recording.captured.push_back(noisy(std::move(captured), noise));
  const auto analysis = analysis_of(recording);
  INFO(analysis.finding.what);
  CHECK(verdict(analysis) == "ok");
  CHECK(std::abs(analysis.delay_frames - 3000.0 * times) < 4.0 * analysis.standard_error_frames);
}

TEST_CASE("analysis: knocks without a cable are no signal", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 1000.0, .gain = 0.0, .noise = 1e-5}.record(probe(), 48_kHz);
  const auto knock = [&](double second, double level) {
    for (int n = 0; n < 4800; ++n)
      recording.captured[0][static_cast<std::size_t>(second * 48000.0) + static_cast<std::size_t>(n)] +=
          level * std::exp(-n / 300.0) * std::sin(2.0 * std::numbers::pi * 700.0 * n / 48000.0);
  };
  knock(0.9, 0.2);
  knock(1.6, 0.05);
  CHECK(verdict(analysis_of(recording)) == "NO_SIGNAL");
}

TEST_CASE("analysis: of one burst nobody knows whether clocks differ", "[latency]") {
  auto samples = measuring_probe(48_kHz).samples(48_kHz);
  samples.insert(samples.begin(), 24000, 0.0);
  const auto analysis =
      analysis_of(SimulatedLoop{.delay_frames = 1234.37, .gain = 0.2, .noise = 1e-4}.record(samples, 48_kHz));
  CHECK_FALSE(analysis.compared);
  CHECK(std::abs(analysis.delay_frames - 1234.37) < 0.0005);
}

TEST_CASE("analysis: peaks that are cut a little are clipping, not lost frames", "[latency]") {
  const double top = GENERATE(0.24, 0.23, 0.21, 0.2);
  auto recording = SimulatedLoop{.delay_frames = 1234.37, .noise = 1e-4}.record(probe(), 48_kHz);
  for (auto& x : recording.captured[0]) x = std::clamp(x, -top, top);
  CHECK(verdict(analysis_of(recording)) != "LOST_FRAMES");
}

TEST_CASE("analysis: an input at full scale is reported", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 960.25, .gain = 4.2}.record(probe(), 48_kHz);
  for (auto& x : recording.captured[0]) x = std::clamp(x, -1.0, 1.0);
  CHECK(verdict(analysis_of(recording)) == "CLIPPING");
}

TEST_CASE("analysis: an amplifier that is overdriven below full scale is reported", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 960.25}.record(probe(), 48_kHz);
  for (auto& x : recording.captured[0]) x = std::clamp(x, -0.1, 0.1);
  CHECK(verdict(analysis_of(recording)) == "CLIPPING");
}

TEST_CASE("analysis: a second path is captured as one", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 960.25, .gain = 0.5, .noise = 1e-4}.record(probe(), 48_kHz);
  const auto direct = recording.captured[0];
  for (std::size_t n = 300; n < direct.size(); ++n) recording.captured[0][n] += 0.2 * direct[n - 300];
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "DIRECT_MONITORING");
  CHECK(analysis.finding.what.find("+300 frames") != std::string::npos);
}

TEST_CASE("analysis: a second path is captured as one at any distance, before the first one or behind it",
          "[latency]") {
  const auto distance = GENERATE(-25000, -9000, 2500, 8500, 60000);
  const auto level = GENERATE(0.5, 0.02);
  CAPTURE(distance, level);
  auto recording =
      SimulatedLoop{.delay_frames = 30960.25, .gain = 0.5, .noise = 1e-5}.record(probe(), 48_kHz, 70000);
  const auto second =
      SimulatedLoop{.delay_frames = 30960.25 + distance, .gain = 0.5 * level}.record(probe(), 48_kHz, 0);
  auto& captured = recording.captured[0];
  for (std::size_t n = 0; n < std::min(captured.size(), second.captured[0].size()); ++n)
    captured[n] += second.captured[0][n];
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "DIRECT_MONITORING");
  REQUIRE(analysis.echo_frames);
  CHECK(std::abs(*analysis.echo_frames - distance) <= 1);
  CAPTURE(analysis.finding.what);
  const double reported =
      std::stod(analysis.finding.what.substr(analysis.finding.what.find_first_of("0123456789")));
  CHECK(reported == Approx(-20 * std::log10(level)).epsilon(0).margin(1.0));
}

TEST_CASE("analysis: a second path is captured as one behind a coupling capacitor", "[latency]") {
  const double level_db = GENERATE(-18.0, -28.8, -38.0);
  const double corner = GENERATE(10.0, 30.0, 60.0);
  CAPTURE(level_db, corner);
  constexpr int kLater = 13719;
  auto recording = SimulatedLoop{.delay_frames = 54.74, .gain = 0.6, .high_pass_hz = {corner}}.record(
      probe(), 48_kHz, kLater + 8000);
  auto& captured = recording.captured[0];
  for (std::size_t n = captured.size(); n-- > kLater;)
    captured[n] += std::pow(10.0, level_db / 20.0) * captured[n - kLater];
  captured = noisy(std::move(captured), 1e-4);
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "DIRECT_MONITORING");
  CHECK(analysis.finding.what.find(fmt::format("{:.1f} dB below the first, +{} frames", -level_db, kLater)) !=
        std::string::npos);
}

TEST_CASE("analysis: a second path is captured as one at low rates, too", "[latency]") {
  const auto [rate, later, level_db] = GENERATE(table<double, int, double>(
      {{8000, 2040, -3.0}, {8000, 1000, -24.0}, {16000, 1700, -22.0}, {22050, 2000, -26.0}}));
  CAPTURE(rate, later, level_db);
  auto recording = SimulatedLoop{.delay_frames = 100.3, .gain = 0.3, .noise = 1e-5}.record(
      stimulus(Hertz{rate}, kLevel), Hertz{rate}, 9000);
  auto& captured = recording.captured[0];
  for (std::size_t n = captured.size(); n-- > index(later);)
    captured[n] += std::pow(10.0, level_db / 20.0) * captured[n - index(later)];
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "DIRECT_MONITORING");
  CHECK(analysis.finding.what.find(fmt::format("+{} frames", later)) != std::string::npos);
}

TEST_CASE("analysis: more frames lost than a sweep is searched for are no second path", "[latency]") {
  const auto at = GENERATE(0.3, 0.5, 0.7, 0.9);
  auto recording = SimulatedLoop{.delay_frames = 30960.25, .noise = 1e-4}.record(probe(), 48_kHz);
  auto& captured = recording.captured[0];
  const auto from = captured.begin() + static_cast<std::ptrdiff_t>(at * static_cast<double>(probe().size()));
  captured.erase(from, from + 12000);
  CHECK(verdict(analysis_of(recording)) == "LOST_FRAMES");
}

TEST_CASE("analysis: of a recording that begins late or ends early, the whole sweeps count", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 960.25, .noise = 1e-4}.record(probe(), 48_kHz);
  auto& captured = recording.captured[0];
  const auto sweeps = find_bursts(probe(), 48_kHz)->repeated;
  REQUIRE(sweeps.size() == 8);
  SECTION("it ends within the fifth sweep") {
    captured.resize(static_cast<std::size_t>(sweeps[4].end()));
    const auto analysis = analysis_of(recording);
    CHECK(verdict(analysis) == "ok");
    CHECK(analysis.probes.size() == 4);
    CHECK(analysis.delay_frames == Approx(960.25).epsilon(0).margin(0.001));
  }
  SECTION("it begins within the second sweep") {
    const auto late = sweeps[1].at + 2000;
    captured.erase(captured.begin(), captured.begin() + static_cast<std::ptrdiff_t>(late));
    const auto analysis = analysis_of(recording);
    CHECK(verdict(analysis) == "ok");
    CHECK(analysis.probes.size() == 6);
    CHECK(analysis.delay_frames == Approx(960.25 - static_cast<double>(late)).epsilon(0).margin(0.001));
  }
  SECTION("it has two from beginning to end") {
    captured.resize(static_cast<std::size_t>(sweeps[2].end()));
    const auto analysis = analysis_of(recording);
    CHECK(verdict(analysis) == "NO_SIGNAL");
  }
}

TEST_CASE("analysis: what comes before the first whole sweep is no noise", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 500.25, .gain = 0.1, .noise = 1e-4}.record(probe(), 48_kHz);
  const double noise_floor = analysis_of(recording).noise_floor_dbfs;
  auto& captured = recording.captured[0];
  SECTION("it begins within a sweep") { captured.erase(captured.begin(), captured.begin() + 30000); }
  SECTION("it ends within the pilot") { captured.resize(208000); }
  SECTION("both") {
    captured.resize(208000);
    captured.erase(captured.begin(), captured.begin() + 30000);
  }
  const auto analysis = analysis_of(recording);
  CHECK(verdict(analysis) == "ok");
  CHECK(analysis.noise_floor_dbfs == Approx(noise_floor).epsilon(0).margin(0.5));
  CHECK(analysis.standard_error_frames < 1e-3);
}

TEST_CASE("analysis: silence within the first sweep is no cable's delay", "[latency]") {
  const auto frames = GENERATE(9000, 20000);
  auto recording = SimulatedLoop{.delay_frames = 500.25, .noise = 1e-4}.record(probe(), 48_kHz);
  auto& captured = recording.captured[0];
  captured.insert(captured.begin() + 30000, static_cast<std::size_t>(frames), 0.0);
  CHECK(verdict(analysis_of(recording)) == "LOST_FRAMES");
}

TEST_CASE("analysis: a gap in the pilot is captured", "[latency]") {
  const auto from = GENERATE(204000, 212000), frames = GENERATE(64, 500);
  auto recording = SimulatedLoop{.delay_frames = 500.25, .noise = 1e-4}.record(probe(), 48_kHz);
  std::fill_n(recording.captured[0].begin() + from, frames, 0.0);
  CHECK(verdict(analysis_of(recording)) == "LOST_FRAMES");
}

TEST_CASE("analysis: hum is no signal", "[latency]") {
  auto recording = SimulatedLoop{.gain = 0.0, .noise = 1e-3}.record(probe(), 48_kHz);
  const double level = GENERATE(0.3, 0.1);
  for (std::size_t n = 0; n < recording.captured[0].size(); ++n)
    for (int k = 1; k < 8; ++k)
      recording.captured[0][n] +=
          level / k * std::sin(2 * std::numbers::pi * 50.0 * k / 48000.0 * static_cast<double>(n));
  CHECK(verdict(analysis_of(recording)) == "NO_SIGNAL");
}

TEST_CASE("analysis: a gain that rises is reported", "[latency]") {
  auto recording = SimulatedLoop{.delay_frames = 500.25, .noise = 1e-4}.record(probe(), 48_kHz);
  auto& captured = recording.captured[0];
  for (std::size_t n = 0; n < captured.size(); ++n)
    captured[n] *= std::pow(2.0, static_cast<double>(n) / static_cast<double>(captured.size()));
  CHECK(verdict(analysis_of(recording)) == "AGC");
}

TEST_CASE("analysis: noise that leaves the delay uncertain is reported", "[latency]") {
  const auto analysis =
      analysis_of({.delay_frames = 960.25, .gain = 0.002, .noise = noise_for(-27.0, 0.002)});
  CHECK(verdict(analysis) == "LOW_SNR");
}

TEST_CASE("analysis: a path that is no cable is refused, and measured with its profile", "[latency]") {
  // a resonance at 900 Hz, as the impulse response of one pole pair
  PathProfile profile;
  for (int n = 0; n < 4000; ++n)
    profile.taps.push_back(std::exp(-0.004 * n) * std::sin(2 * std::numbers::pi * 900.0 / 48000.0 * (n + 1)));
  profile.low = 20_Hz;
  profile.high = 20_kHz;
  auto recording = SimulatedLoop{.delay_frames = 960.25, .gain = 0.1}.record(probe(), 48_kHz);
  const auto direct = recording.captured[0];
  Fourier fourier{direct.size() + profile.taps.size()};
  auto spectrum = fourier.forward(direct);
  const auto path = fourier.forward(profile.taps);
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= path[b];
  recording.captured[0] = fourier.inverse(spectrum);
  recording.captured[0].resize(direct.size());
  for (auto& sample : recording.captured[0]) sample *= 0.02;  // the resonance amplifies by 40 dB
  CHECK(verdict(analysis_of(recording)) == "NOT_FLAT");

  AnalysisSettings settings;
  settings.profile = profile;
  const auto analysis = analyze(recording, settings);
  REQUIRE(analysis);
  CHECK(verdict(*analysis) == "ok");
  CHECK(analysis->delay_frames == Approx(960.25).epsilon(0).margin(0.001));
}

TEST_CASE("analysis: what cannot be analysed says why", "[latency]") {
  LoopRecording recording{48_kHz, std::vector<double>(1000, 0.0), {std::vector<double>(1000, 0.0)}};
  CHECK(test::summary(analyze(recording)) == "BadArgument");
  AnalysisSettings settings;
  settings.channel = 1;
  CHECK(test::summary(analyze(recording, settings)) == "BadArgument 2 1 1");
  recording.captured[0].clear();
  CHECK(test::summary(analyze(recording)) == "BadArgument");
}
