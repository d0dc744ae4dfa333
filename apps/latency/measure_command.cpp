#include <fmt/format.h>

#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/interrupts.h"
#include "apps/cli/writable.h"
#include "apps/latency/keep_delay.h"
#include "apps/latency/latency_commands.h"
#include "apps/latency/measure_now.h"

namespace tactus::app {
namespace {

struct MeasureOptions {
  LoopOptions loop;
  ReportFiles report;
  bool no_keep = false;
};

/// Errors do not invalidate a measurement: they are reported, and set the exit code.
int keep(LatencyReport& report, const Loop& loop, const MeasureOptions& options) {
  if (!report.ok() || options.no_keep) return kDone;
  const auto kept = [&](const Status& status, const std::string& words) -> int {
    if (!status) return app::report(status.error()), kBadFile;
    report.kept.push_back(words);
    return kDone;
  };
  const int on_machine = kept(keep_on_machine(report.measurement),
                              MeasuredDelays::default_file().string() + ", where tactus play looks for it");
  if (!loop.rig) return on_machine;
  const auto& file = options.loop.rig;
  const int in_rig = kept(keep_in_rig(report.measurement, *loop.rig, file),
                          fmt::format("{0}, as [delay] measured; what it was is {0}~", file));
  return on_machine != kDone ? on_machine : in_rig;
}

int run_latency_measure(const MeasureOptions& options) {
  auto loop = make_loop(options.loop);
  if (!loop) return report(loop.error().errors), loop.error().exit;
  install_signal_handlers();
  auto measured = measure_now(*loop->devices.backend, loop->settings);
  if (!measured) return report(measured.error()), exit_of(measured.error());
  if (!*measured) return fmt::print(stderr, "interrupted: nothing was kept\n"), kInterrupted;
  LatencyReport found;
  found.live = true;
  found.measurement = std::move(**measured);
  if (const auto* shown = found.shown()) found.source = source_in_words(loop->settings, shown->granted);
  const int kept = keep(found, *loop, options);
  const int published = publish(std::move(found), options.report);
  return published != kDone ? published : kept;
}

}  // namespace

void add_latency_measure(CLI::App& latency, int& exit_code) {
  auto* command = latency.add_subcommand("measure", "Measure the delay of a card with a cable in loop");
  auto options = std::make_shared<MeasureOptions>();
  auto& loop = options->loop;
  add_loop_options(*command, loop);
  add_setting_options(*command, loop);
  command->add_option("--profile", loop.profile,
                      "what is in the loop instead of a cable: a file of tactus latency calibrate");
  command->add_option("--openings", loop.openings, "how often the stream is opened")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--sweeps", loop.sweeps, "each time")->check(CLI::Range(2, 100))->capture_default_str();
  add_report_options(*command, options->report);
  command->add_option("--wav", options->report.sound, "save the recording (played and captured), for analyze")
      ->check(writable_file());
  command->add_flag("--no-keep", options->no_keep, "write the delay nowhere");
  command->footer(
      "Examples:\n  tactus latency measure --device jack:system\n"
      "  tactus latency measure --device USB --in 2 --out 2 --rate \"96 kHz\" --block 64\n"
      "  tactus latency measure --rig desk.toml --folder delay\n"
      "Connect the output with the input by a cable, and disconnect the speakers: the probe starts at a low "
      "level "
      "and is raised only as far as needed.\n"
      "Exit code 1: no reliable delay; the report gives the reason and the remedy.");
  command->callback([options, &exit_code] { exit_code = run_latency_measure(*options); });
}

}  // namespace tactus::app
