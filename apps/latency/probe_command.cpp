#include <fmt/format.h>

#include "apps/latency/latency.h"
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
  const Hertz rate{parse_option(options.rate, "Hz", "rate", 1e3, 1e6)};
  const double level = parse_level(options.level);
  const Samples samples{rate, {stimulus(rate, amplitude_from_db(level))}};
  if (const auto status = write_wav(options.out, samples, WavEncoding::Pcm24); !status)
    exit_with(status.error(), status.error().code == Errc::BadArgument ? kUsage : kBadFile);
  const double seconds = static_cast<double>(samples.frames()) / rate.value;
  if (options.json)
    print_json({{"written", {options.out}},
                {"sample_rate_hz", rate.value},
                {"level_dbfs", level},
                {"duration_s", seconds}});
  else
    fmt::print("{}: {:.2f} s at {:g} Hz, peak level {:g} dBFS\n", options.out, seconds, rate.value, level);
  return kDone;
}

}  // namespace

void add_latency_probe(CLI::App& latency, int& exit_code) {
  auto [command, options] =
      add_command(latency, "probe",
                  "Write the test signal to a WAV file, to play with another program or on another device",
                  exit_code, run_latency_probe);
  command.add_option("--out", options.out, "file to write: a WAV file of 24 bits")->required();
  command.add_option("--rate", options.rate, "sample rate")->capture_default_str();
  command.add_option("--level", options.level, "highest peak level")->capture_default_str();
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Example:\n  tactus latency probe --out probe.wav\nPlay it and record at the same time in one program; "
      "start the recording before the probe and end it after; then:\n  tactus latency analyze capture.wav "
      "--played probe.wav");
}

}  // namespace tactus::app
