#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/latency/latency_commands.h"
#include "apps/latency/loop_options.h"
#include "backends/wav_file.h"
#include "engine/core/decibels.h"
#include "latency/probe/probe.h"

namespace tactus::app {
namespace {

struct ProbeOptions {
  std::string out, rate = "48 kHz", level = "-12 dBFS";
  bool json = false;
};

int run_latency_probe(const ProbeOptions& options) {
  const auto rate = parse_rate(options.rate, "rate");
  if (!rate) return report(rate.error());
  const auto level = parse_level(options.level, "level");
  if (!level) return report(level.error());
  const Samples samples{*rate, {stimulus(*rate, amplitude_from_db(*level))}};
  if (auto status = write_wav(options.out, samples, WavEncoding::Pcm24); !status) {
    report(status.error());
    return status.error().code == Errc::BadArgument ? kUsage : kBadFile;
  }
  const double seconds = static_cast<double>(samples.frames()) / rate->value;
  if (options.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"written", {options.out}},
                                              {"sample_rate_hz", rate->value},
                                              {"level_dbfs", *level},
                                              {"duration_s", seconds}}
                           .dump(2));
  else
    fmt::print("{}: {:.2f} s at {:g} Hz, peak level {:g} dBFS\n", options.out, seconds, rate->value, *level);
  return kDone;
}

}  // namespace

void add_latency_probe(CLI::App& latency, int& exit_code) {
  auto* command = latency.add_subcommand(
      "probe", "Write the test signal to a WAV file, to play with another program or on another device");
  auto options = std::make_shared<ProbeOptions>();
  command->add_option("--out", options->out, "WAV file to write (24 bit)")->required();
  command->add_option("--rate", options->rate, "sample rate")->capture_default_str();
  command->add_option("--level", options->level, "peak level")->capture_default_str();
  command->add_flag("--json", options->json, "print the parameters of the file as JSON");
  command->footer(
      "Example:\n  tactus latency probe --out probe.wav\n"
      "Play it and record at the same time in one program; start the recording before the probe and end it "
      "after; then:\n"
      "  tactus latency analyze capture.wav --probe probe.wav");
  command->callback([options, &exit_code] { exit_code = run_latency_probe(*options); });
}

}  // namespace tactus::app
