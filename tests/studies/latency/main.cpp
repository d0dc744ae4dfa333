// How well the delay is measured: simulated loops in numbers. See scripts/study_latency.
//   latency_study accuracy COUNT | nothing COUNT | drift COUNT | paths COUNT | methods COUNT      prints a
//   table in Markdown
//   latency_study captures COUNT SPEECH [FIRST] | held_out COUNT SPEECH [FIRST]      the same, beside
//   recorded backgrounds
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "latency/calibration.h"
#include "latency/estimation/analysis.h"
#include "latency/estimation/delay_trend.h"
#include "latency/probe/probe.h"
#include "tests/studies/latency/baselines.h"
#include "tests/studies/latency/captures.h"
#include "tests/studies/latency/in_parallel.h"
#include "tests/support/graphs/plants.h"
#include "tests/support/simulated_loop.h"

namespace {

using namespace tactus;
using namespace tactus::study;
using std::numbers::pi;

constexpr Hertz kRate = 48_kHz;
constexpr double kLevel = 0.5;

double decibels(double power) { return 10.0 * std::log10(power); }

/// The probe, and what the Cramér–Rao bound needs of it.
struct Stimulus {
  std::vector<double> samples = stimulus(kRate, kLevel);
  double power = 0.0;   ///< of a sweep at full level, per sample
  double slopes = 0.0;  ///< sum of s'(n)² over all that is played

  Stimulus() {
    const auto sweep = measuring_probe(kRate).samples(kRate);
    for (const double sample : sweep)
      power += kLevel * kLevel * sample * sample / static_cast<double>(sweep.size());
    Fourier fourier{samples.size()};
    const auto spectrum = fourier.forward(samples);
    for (std::size_t b = 1; b + 1 < spectrum.size(); ++b) {
      const double w = 2 * pi * static_cast<double>(b) / static_cast<double>(fourier.size());
      slopes += 2.0 * w * w * std::norm(spectrum[b]) / static_cast<double>(fourier.size());
    }
  }
};

struct Trial {
  double coupling_hz = 0.0, snr_db = 0.0, error = 0.0, bound = 0.0;
  bool refused = false, wrong_polarity = false;
  std::string verdict;
};

/// Draws a loop, as the issue of accuracy is: any delay up to 200,000 frames, any gain down to -60 dB, either
/// polarity.
struct Draw {
  std::mt19937_64 random;
  explicit Draw(int number) : random(static_cast<std::uint64_t>(number) * 7919 + 1) {}
  double between(double low, double high) { return std::uniform_real_distribution{low, high}(random); }
  bool coin() { return between(0.0, 1.0) < 0.5; }
};

Trial accuracy_trial(const Stimulus& stimulus, int number) {
  Draw draw{number};
  test::SimulatedLoop loop;
  loop.seed = static_cast<std::uint64_t>(number);
  loop.delay_frames = draw.between(0.0, 200000.0);
  const double polarity = draw.coin() ? 1.0 : -1.0;
  const double gain_db = draw.between(-60.0, 0.0);
  loop.bits = draw.coin() ? 16 : 24;
  Trial trial;
  trial.coupling_hz = std::array{0.0, 0.0, 4.0, 30.0}[static_cast<std::size_t>(number % 4)];
  if (trial.coupling_hz > 0.0) loop.high_pass_hz = {trial.coupling_hz};
  const double wanted =
      std::array{-10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0}[static_cast<std::size_t>(number / 4 % 8)];
  // A converter has room for noise of -15 dBFS; a louder one comes with a softer signal.
  const double loudest = -15.0 + wanted - decibels(stimulus.power);
  loop.gain = polarity * std::pow(10.0, std::min(gain_db, loudest) / 20.0);
  const double signal = stimulus.power * loop.gain * loop.gain;
  const double step = std::exp2(1 - loop.bits);
  const double rounding = step * step / 12.0;
  loop.noise = std::sqrt(std::max(signal * std::pow(10.0, -wanted / 10.0) - rounding, 0.01 * rounding));
  const double noise = loop.noise * loop.noise + rounding;
  trial.snr_db = decibels(signal / noise);
  trial.bound = std::sqrt(noise / (loop.gain * loop.gain * stimulus.slopes));

  AnalysisSettings settings;
  settings.details = false;
  const auto analysis = analyze(loop.record(stimulus.samples, kRate), settings).value();
  trial.refused = analysis.finding.verdict != Verdict::Ok;
  trial.verdict = code(analysis.finding.verdict);
  trial.error = analysis.delay_frames - loop.delay_frames;
  trial.wrong_polarity = analysis.polarity != (loop.gain < 0.0 ? -1 : 1);
  return trial;
}

struct Row {
  int trials = 0, refused = 0, gross = 0, wrong_polarity = 0;
  double sum = 0.0, squares = 0.0, bounded = 0.0, worst = 0.0;

  void add(const Trial& trial) {
    ++trials;
    if (trial.refused) return void(++refused);
    if (std::abs(trial.error) > 0.5) return void(++gross);
    wrong_polarity += trial.wrong_polarity;
    sum += trial.error;
    squares += trial.error * trial.error;
    bounded += (trial.error / trial.bound) * (trial.error / trial.bound);
    worst = std::max(worst, std::abs(trial.error));
  }
  std::string text() const {
    const double kept = std::max(1, trials - refused - gross);
    return fmt::format("{} | {} | {} | {} | {:+.6f} | {:.6f} | {:.6f} | {:.3f}", trials, refused, gross,
                       wrong_polarity, sum / kept, std::sqrt(squares / kept), worst,
                       std::sqrt(bounded / kept));
  }
};

void accuracy(int count) {
  const Stimulus stimulus;
  std::vector<Trial> trials(static_cast<std::size_t>(count));
  in_parallel(count, [&](int n) { trials[static_cast<std::size_t>(n)] = accuracy_trial(stimulus, n); });
  fmt::print(
      "| coupling | SNR per sample | loops | refused | gross | wrong polarity | bias | rms error | worst | "
      "rms error / bound |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const double coupling : {0.0, 4.0, 30.0})
    for (double low = -15.0; low < 65.0; low += 10.0) {
      Row row;
      for (const auto& trial : trials)
        if (trial.coupling_hz == coupling && trial.snr_db >= low && trial.snr_db < low + 10.0) row.add(trial);
      if (row.trials > 0)
        fmt::print("| {} | {:+.0f} … {:+.0f} dB | {} |\n",
                   coupling > 0.0 ? fmt::format("{:g} Hz", coupling) : "none", low, low + 10.0, row.text());
    }
  for (const auto& trial : trials)
    if ((trial.refused || std::abs(trial.error) > 0.5))
      fmt::print(stderr, "{} at {:.1f} dB, coupling {}: error {:.4f}\n", trial.verdict, trial.snr_db,
                 trial.coupling_hz, trial.error);
}

/// Everything that is captured without a cable.
std::vector<double> nothing(int number, std::size_t frames) {
  Draw draw{number};
  std::normal_distribution<double> normal;
  const double loudness = std::pow(10.0, draw.between(-120.0, -10.0) / 20.0);
  const double hum = number % 3 == 1 ? loudness * draw.between(0.1, 30.0) : 0.0;
  const double memory = number % 3 == 2 ? draw.between(0.5, 0.9999) : 0.0;
  const double step = draw.coin() ? std::exp2(-15) : std::exp2(-23);
  const double turn = 2 * pi * (draw.coin() ? 50.0 : 60.0) / kRate.value;
  std::vector<double> captured(frames);
  double coloured = 0.0;
  for (std::size_t n = 0; n < frames; ++n) {
    coloured = memory * coloured + std::sqrt(1.0 - memory * memory) * normal(draw.random);
    const double at = turn * static_cast<double>(n);
    captured[n] =
        loudness * coloured + hum * (std::sin(at) + 0.3 * std::sin(3 * at) + 0.1 * std::sin(5 * at));
    captured[n] = std::clamp(std::round(captured[n] / step) * step, -1.0, 1.0);
  }
  return captured;
}

void nothing(int count) {
  const Stimulus stimulus;
  std::atomic<int> refused{0}, silent{0};
  in_parallel(count, [&](int n) {
    LoopRecording recording{kRate, stimulus.samples, {nothing(n, stimulus.samples.size())}};
    AnalysisSettings settings;
    settings.details = false;
    const auto analysis = analyze(recording, settings).value();
    refused += analysis.finding.verdict != Verdict::Ok;
    silent += analysis.finding.verdict == Verdict::NoSignal;
    if (analysis.finding.verdict == Verdict::Ok) fmt::print(stderr, "{}: {}\n", n, analysis.delay_frames);
  });
  fmt::print("| without a cable | refused | of those as NO_SIGNAL |\n|---|---|---|\n| {} | {} | {} |\n",
             count, refused.load(), silent.load());
}

void drift(int count) {
  const Stimulus stimulus;
  std::vector<std::array<double, 2>> errors(static_cast<std::size_t>(count));
  std::atomic<int> reported{0};
  in_parallel(count, [&](int n) {
    Draw draw{n};
    test::SimulatedLoop loop;
    loop.seed = static_cast<std::uint64_t>(n);
    loop.delay_frames = draw.between(0.0, 20000.0);
    const double ppm = n % 2 == 0 ? 50.0 : -50.0;
    auto recording = loop.record(stimulus.samples, kRate, 48000);
    recording.captured[0] = at_speed(recording.captured[0], 1.0 / (1.0 + 1e-6 * ppm));
    std::normal_distribution<double> normal;
    for (auto& sample : recording.captured[0])
      sample += std::sqrt(stimulus.power * 1e-3) * normal(draw.random);
    const auto analysis = analyze(recording).value();
    reported += analysis.finding.verdict == Verdict::ClocksDiffer;
    const double first = static_cast<double>(analysis.probes.front().played_at);
    const double last = static_cast<double>(analysis.probes.back().played_at) +
                        frames_in(measuring_probe(kRate).duration, kRate);
    const double middle = 0.5 * (first + last);
    const double truth = (middle + loop.delay_frames) * (1.0 + 1e-6 * ppm) - middle;
    errors[static_cast<std::size_t>(n)] = {analysis.drift_ppm - ppm, analysis.delay_frames - truth};
  });
  std::array<double, 2> worst{}, squares{};
  for (const auto& error : errors)
    for (std::size_t k = 0; k < 2; ++k) {
      worst[k] = std::max(worst[k], std::abs(error[k]));
      squares[k] += error[k] * error[k] / count;
    }
  fmt::print(
      "| loops, ±50 ppm, 30 dB | reported as CLOCKS_DIFFER | drift: rms error, worst | delay: rms error, "
      "worst "
      "|\n|---|---|---|---|\n");
  fmt::print("| {} | {} | {:.4f}, {:.4f} ppm | {:.5f}, {:.5f} frames |\n", count, reported.load(),
             std::sqrt(squares[0]), worst[0], std::sqrt(squares[1]), worst[1]);
}

/// Through actuators: each calibrated once at some delay of the card, then measured at others.
void paths(int count) {
  const Stimulus stimulus;
  constexpr int kElectrical = 960;
  fmt::print(
      "| path | captured above the noise | loops | refused without its profile | refused with it | rms error "
      "| "
      "worst error |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const auto& plant : test::plants())
    for (const double snr_db : {40.0, 20.0, 10.0}) {
      double power = 0.0;
      const auto quiet = test::through_plant(plant, stimulus.samples, 0, 0.0, 1).captured[0];
      for (const double sample : quiet) power += sample * sample / static_cast<double>(quiet.size());
      const double noise = std::sqrt(power * std::pow(10.0, -snr_db / 10.0));
      CalibrationSettings calibrated;
      calibrated.electrical_frames = kElectrical;
      const auto calibration =
          calibrate(test::through_plant(plant, stimulus.samples, kElectrical, noise, 1), calibrated).value();
      std::vector<std::optional<double>> errors(static_cast<std::size_t>(count));
      std::atomic<int> refused{0};
      in_parallel(count, [&](int n) {
        Draw draw{n};
        const auto delay = static_cast<int>(draw.between(0.0, 20000.0));
        const auto recording =
            test::through_plant(plant, stimulus.samples, delay, noise, static_cast<std::uint64_t>(n) + 2);
        AnalysisSettings settings;
        settings.details = false;
        refused += analyze(recording, settings).value().finding.verdict != Verdict::Ok;
        settings.profile = calibration.profile;
        const auto analysis = analyze(recording, settings).value();
        if (analysis.finding.verdict == Verdict::Ok)
          errors[static_cast<std::size_t>(n)] = 1e3 * (analysis.delay_frames - delay) / kRate.value;
      });
      double squares = 0.0, worst = 0.0;
      int kept = 0;
      for (const auto& error : errors)
        if (error) {
          ++kept;
          squares += *error * *error;
          worst = std::max(worst, std::abs(*error));
        }
      const auto errors_text = kept == 0
                                   ? std::string{"- | -"}
                                   : fmt::format("{:.5f} ms | {:.5f} ms", std::sqrt(squares / kept), worst);
      fmt::print("| {} | {:.0f} dB | {} | {} | {} | {} |\n", plant.name, snr_db, count, refused.load(),
                 count - kept, errors_text);
    }
}

/// One way to measure: what it plays, and what it makes of what is captured.
struct Method {
  std::string name;
  std::vector<double> played;
  std::function<double(const LoopRecording&)> delay;
};

std::vector<Method> methods(const Stimulus& stimulus) {
  return {{"ours", stimulus.samples,
           [](const LoopRecording& recording) {
             AnalysisSettings settings;
             settings.details = false;
             const auto analysis = analyze(recording, settings).value();
             return analysis.finding.verdict == Verdict::Ok ? analysis.delay_frames : std::nan("");
           }},
          {"cross-correlation, parabola", stimulus.samples,
           [](const LoopRecording& recording) {
             return correlate_with_parabola(recording.played, recording.captured[0]);
           }},
          {"phases of five tones", five_tones(4 * 65536 + 65536, kLevel), [](const LoopRecording& recording) {
             return phase_delay_of_tones(std::span{recording.captured[0]}.first(5 * 65536), 65536);
           }}};
}

/// Errors of all methods in the same loops, with the time that each took. One core, so that times compare.
void compare(int count) {
  const Stimulus stimulus;
  const auto all = methods(stimulus);
  fmt::print(
      "| loop | method | rms error, frames | gross errors | refused | ms a loop "
      "|\n|---|---|---|---|---|---|\n");
  struct Case {
    std::string name;
    double snr_db, coupling_hz, longest;
  };
  for (const auto& each :
       {Case{"60 dB", 60, 0, 65000}, Case{"30 dB", 30, 0, 65000}, Case{"10 dB", 10, 0, 65000},
        Case{"0 dB", 0, 0, 65000}, Case{"-10 dB", -10, 0, 65000},
        Case{"60 dB, 30 Hz coupling", 60, 30, 65000}, Case{"60 dB, delays above 65,536", 60, 0, 200000}})
    for (const auto& method : all) {
      double squares = 0.0, seconds = 0.0;
      int gross = 0, refused = 0;
      for (int n = 0; n < count; ++n) {
        Draw draw{n};
        test::SimulatedLoop loop;
        loop.seed = static_cast<std::uint64_t>(n);
        loop.delay_frames = draw.between(each.longest > 65536 ? 65536.0 : 0.0, each.longest);
        loop.gain = draw.coin() ? 0.1 : -0.1;
        if (each.coupling_hz > 0.0) loop.high_pass_hz = {each.coupling_hz};
        loop.noise = std::sqrt(stimulus.power * loop.gain * loop.gain * std::pow(10.0, -each.snr_db / 10.0));
        const auto recording = loop.record(method.played, kRate);
        const auto begin = std::chrono::steady_clock::now();
        const double error = method.delay(recording) - loop.delay_frames;
        seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        if (std::isnan(error))
          ++refused;
        else if (std::abs(error) > 0.5)
          ++gross;
        else
          squares += error * error;
      }
      const int kept = std::max(1, count - gross - refused);
      fmt::print("| {} | {} | {:.2e} | {} | {} | {:.0f} |\n", each.name, method.name,
                 std::sqrt(squares / kept), gross, refused, 1e3 * seconds / count);
    }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const int count = argc > 2 ? std::stoi(argv[2]) : 100;
  if (what == "accuracy") return accuracy(count), 0;
  if (what == "nothing") return nothing(count), 0;
  if (what == "drift") return drift(count), 0;
  if (what == "paths") return paths(count), 0;
  if (what == "methods") return compare(count), 0;
  if ((what == "captures" || what == "held_out") && argc > 3)
    return captures(argc > 4 ? std::stoi(argv[4]) : 0, count, what == "held_out", argv[3]);
  fmt::print(stderr,
             "accuracy, nothing, drift, paths or methods, and how many loops; captures or held_out, how "
             "many, a folder of speech, and the first number\n");
  return 2;
}
