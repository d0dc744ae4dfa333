#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <thread>

#include "apps/cli/commands.h"
#include "apps/cli/json.h"
#include "apps/doctor/findings.h"
#include "backends/realtime_thread.h"

namespace tactus::app {
namespace {

constexpr int kPriority = 70;  // below that of the threads of interrupts, 50 + 40 with rtirq

/// On a thread of its own, which takes its priority with it when it ends.
Status try_priority() {
  Status tried;
  std::thread{[&] { tried = become_realtime(kPriority); }}.join();
  return tried;
}

/// The settings of a PipeWire that runs; empty where there is none.
std::string pipewire_settings([[maybe_unused]] const SystemFiles& system) {
  std::string text;
#if defined(__linux__)
  const auto processes = processes_of(system);
  if (std::none_of(processes.begin(), processes.end(),
                   [](const Process& process) { return process.name == "pipewire"; }))
    return text;
  std::FILE* pipe = popen("timeout 2 pw-metadata -n settings 0 2>/dev/null </dev/null", "r");
  if (pipe == nullptr) return text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  pclose(pipe);
#endif
  return text;
}

void print(const SystemFinding& finding) {
  fmt::print("{:8} {:18}  {}\n", name_of(finding.state), finding.name, finding.what);
  if (!finding.command.empty()) fmt::print("{:29}{}\n", "", finding.command);
}

Json finding_json(const SystemFinding& finding) {
  return {{"name", finding.name},
          {"state", name_of(finding.state)},
          {"what", finding.what},
          {"command", finding.command}};
}

struct DoctorOptions {
  bool json = false;
};

int run_doctor(const DoctorOptions& options) {
  const SystemFiles system;
  const auto findings = check_system(system, try_priority(), lock_memory(), pipewire_settings(system));
  const bool warned = std::any_of(findings.begin(), findings.end(), [](const SystemFinding& finding) {
    return finding.state == SystemFinding::State::Warn;
  });
  if (options.json) print_json({{"ok", !warned}, {"findings", list_of(findings, finding_json)}});
  for (const auto& finding : findings)
    if (!options.json) print(finding);
  return warned ? kNo : kDone;
}

}  // namespace

void add_doctor(CLI::App& app, int& exit_code) {
  auto [command, options] =
      add_command(app, "doctor", "Check whether this system is fit for short delays", exit_code, run_doctor);
  command.add_flag("--json", options.json, "for machines");
  command.footer(
      "Example:\n  tactus doctor\nIt changes nothing; each finding is followed by the command that fixes it, "
      "or that shows more.\nExit code 1: at least one warning.");
}

}  // namespace tactus::app
