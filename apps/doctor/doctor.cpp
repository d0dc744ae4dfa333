#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/cli/commands.h"
#include "apps/doctor/findings.h"
#include "backends/realtime_thread.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

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

int run_doctor(bool json) {
  const auto priority = try_priority();
  const auto memory = lock_memory();
  const SystemFiles system;
  const auto findings = check_system(system, priority, memory, pipewire_settings(system));
  const auto warnings = std::count_if(findings.begin(), findings.end(), [](const SystemFinding& finding) {
    return finding.state == SystemFinding::State::Warn;
  });
  if (json) {
    Json all{{"ok", warnings == 0}, {"findings", Json::array()}};
    for (const auto& finding : findings)
      all["findings"].push_back({{"name", finding.name},
                                 {"state", name_of(finding.state)},
                                 {"what", finding.what},
                                 {"command", finding.command}});
    fmt::print("{}\n", all.dump(2));
  } else {
    for (const auto& finding : findings) print(finding);
  }
  return warnings == 0 ? kDone : kNo;
}

}  // namespace

void add_doctor(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("doctor", "Check whether this system is set up for low-latency audio");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "print the findings as JSON");
  command->footer(
      "Example:\n  tactus doctor\nIt only reads settings. Each finding is followed by the command that fixes "
      "it or shows more.\nExit code 1: at least one warning.");
  command->callback([json, &exit_code] { exit_code = run_doctor(*json); });
}

}  // namespace tactus::app
