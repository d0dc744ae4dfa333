#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <string>

#include "apps/latency/latency_report.h"

namespace tactus::app {

// Each adds itself below `tactus latency`.
void add_latency_measure(CLI::App& latency, int& exit_code);
void add_latency_probe(CLI::App& latency, int& exit_code);
void add_latency_analyze(CLI::App& latency, int& exit_code);
void add_latency_sweep(CLI::App& latency, int& exit_code);
void add_latency_calibrate(CLI::App& latency, int& exit_code);

/// Where a report goes, beside stdout.
struct ReportFiles {
  std::string folder;   ///< all of them
  std::string picture;  ///< an SVG
  std::string sound;    ///< what was played and captured
  bool json = false;    ///< stdout is for machines
};

/// --folder, --report, --json
void add_report_options(CLI::App& command, ReportFiles& files);
/// Writes the files, prints the report, and gives the exit code.
int publish(LatencyReport report, const ReportFiles& files);

}  // namespace tactus::app
