#include <fmt/format.h>

#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/latency/latency_commands.h"
#include "apps/latency/latency_files.h"
#include "apps/latency/loop_options.h"
#include "latency/estimation/analysis.h"

namespace tactus::app {
namespace {

struct AnalyzeOptions {
  CaptureFiles files;
  std::string rate, profile;
  ReportFiles report;
};

LatencyReport report_of(const std::string& source, Capture capture, Analysis analysis) {
  LatencyReport report;
  report.source = source;
  auto& measurement = report.measurement;
  measurement.finding = analysis.finding;
  measurement.delay_frames = analysis.delay_frames;
  measurement.standard_error_frames = analysis.standard_error_frames;
  auto& opening = measurement.openings.emplace_back();
  opening.finding = analysis.finding;
  opening.recording = std::move(capture.recording);
  opening.analysis = std::move(analysis);
  return report;
}

int run_latency_analyze(AnalyzeOptions options) {
  if (!options.rate.empty()) {
    const auto rate = parse_rate(options.rate, "rate");
    if (!rate) return report(rate.error());
    options.files.rate = *rate;
  }
  auto capture = read_capture(options.files);
  if (!capture) return report(capture.error());
  if (!capture->note.empty()) fmt::print(stderr, "note: {}\n", capture->note);
  AnalysisSettings settings;
  settings.channel = capture->channel;
  if (!options.profile.empty()) {
    auto profile = read_profile(options.profile, capture->recording.sample_rate);
    if (!profile) return report(profile.error());
    settings.profile = std::move(*profile);
  }
  auto analysis = analyze(capture->recording, settings);
  if (!analysis) return report(analysis.error()), kBadFile;
  if (analysis->detected && analysis->delay_frames < -0.5)
    fmt::print(stderr, "note: the recording started after the probe, so this is not the delay of a device\n");
  const auto source =
      fmt::format("{}, {:g} kHz", options.files.capture, capture->recording.sample_rate.value / 1e3);
  return publish(report_of(source, std::move(*capture), std::move(*analysis)), options.report);
}

}  // namespace

void add_latency_analyze(CLI::App& latency, int& exit_code) {
  auto* command = latency.add_subcommand("analyze", "Find the delay in a recording");
  auto options = std::make_shared<AnalyzeOptions>();
  command->add_option("FILE", options->files.capture, "WAV file of the captured signal")->required();
  command->add_option("--probe", options->files.probe,
                      "WAV file that was played; default: the first channel of FILE");
  command
      ->add_option("--channel", options->files.channel,
                   "channel of FILE with the captured signal, counted from 1; default: 1, or 2 if channel 1 "
                   "is the probe")
      ->check(CLI::Range(1, 1024));
  command->add_option("--rate", options->rate, "actual sample rate, if the headers of the files are wrong");
  command->add_option(
      "--profile", options->profile,
      "profile of the actuator and sensor in the loop, saved by tactus latency calibrate; default: a cable");
  add_report_options(*command, options->report);
  command->footer(
      "Examples:\n  tactus latency analyze capture.wav --probe probe.wav\n"
      "  tactus latency analyze capture.wav --probe probe.wav --channel 2 --report delay.svg\n"
      "  tactus latency analyze raw.wav     # saved by tactus latency measure --wav raw.wav\n"
      "The delay is measured from the start of the probe file to the start of the probe in FILE. It equals "
      "the delay of\nthe device only if playback and recording started in the same frame.\n"
      "Exit code 1: no reliable delay in the recording; the report gives the reason.");
  command->callback([options, &exit_code] { exit_code = run_latency_analyze(*options); });
}

}  // namespace tactus::app
