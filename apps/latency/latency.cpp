#include <fmt/format.h>

#include "apps/cli/commands.h"
#include "apps/latency/latency_commands.h"

namespace tactus::app {

void add_latency(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand(
      "latency", "Measure the round-trip latency of a card, or the response of an actuator and a sensor");
  command->require_subcommand(0, 1);
  add_latency_measure(*command, exit_code);
  add_latency_sweep(*command, exit_code);
  add_latency_calibrate(*command, exit_code);
  add_latency_probe(*command, exit_code);
  add_latency_analyze(*command, exit_code);
  command->footer(
      "Examples:\n  tactus latency measure --device jack:system\n"
      "  tactus latency sweep --device jack:system --blocks 64,128,256\n"
      "  tactus latency probe --out probe.wav\n"
      "  tactus latency analyze capture.wav --probe probe.wav\n"
      "docs/latency.md describes the connections and the verdicts.");
  command->callback([command] {
    if (command->get_subcommands().empty()) fmt::print("{}", command->help("tactus"));
  });
}

}  // namespace tactus::app
