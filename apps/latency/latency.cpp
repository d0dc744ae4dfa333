#include "apps/latency/latency.h"

namespace tactus::app {

void add_latency(CLI::App& app, int& exit_code) {
  auto& group = add_command_group(
      app, "latency", "Measure the round-trip latency of a card, or the response of an actuator and a sensor",
      "Examples:\n  tactus latency measure --device jack:system\n"
      "  tactus latency sweep --device jack:system --blocks 64,128,256\n"
      "  tactus latency probe --out probe.wav\n"
      "  tactus latency analyze capture.wav --played probe.wav\n"
      "docs/latency.md describes the connections and the verdicts.");
  for (auto* add : {add_latency_measure, add_latency_sweep, add_latency_calibrate, add_latency_probe,
                    add_latency_analyze})
    add(group, exit_code);
}

}  // namespace tactus::app
