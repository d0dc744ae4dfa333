#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <string>

#include "apps/cli/rig_files.h"
#include "apps/latency/latency.h"
#include "latency/measured.h"

namespace tactus::app {
namespace {

struct MeasureOptions {
  LoopOptions loop;
  ReportFiles report;
  bool no_save = false;
};

Seconds in_seconds(double frames, const StreamGranted& granted) {
  return Seconds{frames / granted.format.sample_rate.value};
}

/// Puts a measured delay into a rig. The setting that was left to the card is put there too: with another one
/// the delay would be wrong.
void set_delay(const Measurement& measurement, Rig& rig) {
  const auto& granted = measurement.openings.front().granted;
  auto& device = rig.device;
  rig.measured_delay = in_seconds(measurement.delay_frames, granted);
  device.rate = granted.format.sample_rate;
  if (granted.block_frames > 0) device.block = granted.block_frames;
  if (granted.periods > 0) device.periods = granted.periods;
}

/// The high-pass of the loop, output and input together: of each output of the rig that was measured through.
void set_highpass(const Measurement& measurement, int channel, Rig& rig) {
  const auto highpass = highpass_of(measurement.shown().analysis);
  for (auto& output : rig.outputs)
    if (highpass.corner && output.uses(channel))
      output.highpass = Hertz{std::stod(fmt::format("{:.3g}", highpass.corner->value))};
}

/// Errors do not invalidate a measurement: they are reported, and set the exit code.
int save(LatencyReport& report, const Loop& loop, const MeasureOptions& options) {
  if (!report.ok() || options.no_save) return kDone;
  int exit = kDone;
  const auto note = [&](const std::vector<Error>& errors, const std::string& where) {
    if (errors.empty()) return report.saved.push_back(where);
    app::report({errors});
    exit = kBadFile;
  };
  const auto& granted = report.measurement.openings.front().granted;
  const auto kept =
      MeasuredDelays::load().save({key_of(granted), in_seconds(report.measurement.delay_frames, granted),
                                   in_seconds(report.measurement.spread_frames, granted),
                                   fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))});
  note(kept ? std::vector<Error>{} : std::vector{kept.error()},
       MeasuredDelays::default_file().string() + ", where tactus play reads it");
  const auto& file = options.loop.rig;
  if (loop.rig)
    note(change_rig(file, loop.rig->device,
                    [&](Rig& rig) {
                      set_delay(report.measurement, rig);
                      set_highpass(report.measurement, loop.settings.output + 1, rig);
                    }),
         fmt::format(
             "{0} ('measured' of [delay], 'output_highpass' of the output if it was found); the previous "
             "version is {0}~",
             file));
  return exit;
}

int run_latency_measure(const MeasureOptions& options) {
  const auto loop = make_loop(options.loop);
  install_signal_handlers();
  auto measured = measure_now(*loop.devices.backend, loop.settings);
  if (!measured) exit_with(measured.error(), exit_of(measured.error()));
  LatencyReport found;
  found.live = true;
  found.measurement = std::move(*measured);
  found.source = source_text(loop.settings, found.measurement.shown().granted);
  const int saved = save(found, loop, options);
  const int published = publish(std::move(found), options.report);
  return published != kDone ? published : saved;
}

}  // namespace

void add_latency_measure(CLI::App& latency, int& exit_code) {
  auto [command, options] =
      add_command(latency, "measure", "Measure the round-trip latency of a card with a loopback cable",
                  exit_code, run_latency_measure);
  auto& loop = options.loop;
  add_loop_options(command, loop, true, true);
  add_profile_option(command, loop.profile);
  add_report_options(command, options.report, true, true);
  command.add_flag("--no-save", options.no_save, "do not save the measured delay");
  command.footer(
      "Examples:\n  tactus latency measure --device jack:system\n  tactus latency measure --device USB "
      "--input "
      "2 --output 2 --rate \"96 kHz\" --block 64\n  tactus latency measure --rig desk.toml --folder "
      "delay\nConnect the output to the input with a cable, and disconnect the speakers: the probe starts at "
      "a low level and is raised only as far as needed.\nExit code 1: no reliable delay; the report gives "
      "the reason and the remedy.");
}

}  // namespace tactus::app
