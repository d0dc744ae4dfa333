#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/latency/latency.h"
#include "apps/render/render.h"
#include "backends/wav_file.h"
#include "latency/estimation/analysis.h"

namespace tactus::app {
namespace {

struct AnalyzeOptions {
  std::string capture;         ///< a WAV file
  std::string probe;           ///< what was played; empty: it is the first channel of `capture`
  std::optional<int> channel;  ///< of `capture`, from 1; left out: the first that was captured
  std::string rate;            ///< of both, where their headers are wrong
  std::string profile;
  ReportFiles report;
};

struct Capture {
  LoopRecording recording;
  int channel = 0;  ///< of `recording.captured`, from 0
};

void check(const Samples& samples, const std::string& path) {
  if (samples.frames() == 0) exit_with({Errc::BadFile, path, "it contains no samples", "record it again"});
  if (!(samples.sample_rate >= 1_kHz && samples.sample_rate.value <= 1e6))
    exit_with({Errc::BadFile, path,
               fmt::format("its header states a sample rate of {:g} Hz, which no sound card supports",
                           samples.sample_rate.value),
               "give the actual rate with --rate"});
  for (const auto& channel : samples.channels)
    if (!std::all_of(channel.begin(), channel.end(), [](double sample) { return std::isfinite(sample); }))
      exit_with({Errc::BadFile, path, "some of its samples are non-finite", "record it again"});
}

Samples read(const std::string& path, const AnalyzeOptions& options) {
  auto samples = or_exit(read_wav(path), kBadFile);
  if (!options.rate.empty()) samples.sample_rate = Hertz{parse_option(options.rate, "Hz", "rate", 1e3, 1e6)};
  check(samples, path);
  return samples;
}

/// Which of the channels that were captured; `first`: the channel of the file that they begin with, from 1.
int captured_channel(const AnalyzeOptions& options, int first, int channels) {
  const int asked = options.channel.value_or(first);
  if (asked >= first && asked < first + channels) return asked - first;
  exit_with({Errc::BadArgument, "--channel",
             first == 2 && asked == 1 ? "without --played, channel 1 must be the played signal"
                                      : fmt::format("'{}' has no channel {}", options.capture, asked),
             channels == 1 ? fmt::format("it has only channel {}", first)
                           : fmt::format("it has channels {} to {}", first, first + channels - 1)});
}

/// Three of eight sweeps are enough: a recording may be cut, to less than half of the probe.
constexpr double kMostProbes = 4.0;

/// At the rate of this recording, where it can be in it at all.
Samples at_rate(Samples probe, const AnalyzeOptions& options, const Samples& recording) {
  const auto rate = recording.sample_rate;
  if (probe.sample_rate == rate) return probe;
  const auto seconds = [](const Samples& of) {
    return static_cast<double>(of.frames()) / of.sample_rate.value;
  };
  if (seconds(probe) > kMostProbes * seconds(recording))
    exit_with({Errc::BadFile, options.probe,
               fmt::format("the probe lasts {:.3g} s at {:g} Hz, the recording only {:.3g} s", seconds(probe),
                           probe.sample_rate.value, seconds(recording)),
               "record the whole probe; if only a header is wrong, give --rate"});
  fmt::print(stderr,
             "note: the probe file is at {:g} Hz and the recording at {:g} Hz: the probe was resampled; if "
             "only a header is wrong, give --rate\n",
             probe.sample_rate.value, rate.value);
  return resample(probe, rate);
}

/// A file whose first channel is what was played, or two files as if they had begun together.
Capture capture_of(const AnalyzeOptions& options) {
  auto samples = read(options.capture, options);
  auto& channels = samples.channels;
  const bool together = options.probe.empty();
  if (together && channels.size() < 2)
    exit_with({Errc::BadFile, options.capture, "it has one channel, and no probe file is given",
               "give the file that was played as --played"});
  const int first = together ? 2 : 1;
  const int channel = captured_channel(options, first, static_cast<int>(channels.size()) + 1 - first);
  std::vector<double> played;
  if (together) {
    played = std::move(channels.front());
    channels.erase(channels.begin());
  } else {
    auto probe = at_rate(read(options.probe, options), options, samples);
    played = std::move(probe.channels.front());
    played.resize(std::max(played.size(), channels.front().size()));
  }
  return {{samples.sample_rate, std::move(played), std::move(channels)}, channel};
}

int run_latency_analyze(const AnalyzeOptions& options) {
  auto capture = capture_of(options);
  const auto rate = capture.recording.sample_rate;
  AnalysisSettings settings{capture.channel, {}};
  if (!options.profile.empty()) settings.profile = read_profile(options.profile, rate);
  LatencyReport report;
  report.source = fmt::format("{}, {:g} kHz", options.capture, rate.value / 1e3);
  auto& opening = report.measurement.openings.emplace_back();
  opening.analysis = or_exit(analyze(capture.recording, settings), kBadFile);
  opening.recording = std::move(capture.recording);
  opening.finding = opening.analysis.finding;
  static_cast<DelayEstimate&>(report.measurement) = opening.analysis;
  if (opening.analysis.detected && opening.analysis.delay_frames < -0.5)
    fmt::print(stderr, "note: the recording started after the probe, so this is not the delay of a device\n");
  return publish(std::move(report), options.report);
}

}  // namespace

void add_latency_analyze(CLI::App& latency, int& exit_code) {
  auto [command, options] =
      add_command(latency, "analyze", "Find the delay in a recording", exit_code, run_latency_analyze);
  command.add_option("FILE", options.capture, "WAV file of the captured signal")->required();
  command.add_option("--played", options.probe,
                     "WAV file that was played; default: the first channel of FILE");
  add_number(
      command, "--channel", options.channel,
      "channel of FILE with the captured signal, counted from 1; default: 1, or 2 if channel 1 is the probe",
      1, 1024);
  command.add_option("--rate", options.rate, "sample rate; if the headers of the files are wrong");
  add_profile_option(command, options.profile);
  add_report_options(command, options.report, true, false);
  command.footer(
      "Examples:\n  tactus latency analyze capture.wav --played probe.wav\n  tactus latency analyze "
      "capture.wav --played probe.wav --channel 2 --svg delay.svg\n  tactus latency analyze raw.wav     # "
      "saved by tactus latency measure --wav raw.wav\nThe delay is measured from the start of the probe file "
      "to the start of the probe in FILE. It equals the delay of\nthe device only if playback and recording "
      "started in the same frame.\nExit code 1: no reliable delay in the recording; the report gives the "
      "reason.");
}

}  // namespace tactus::app
