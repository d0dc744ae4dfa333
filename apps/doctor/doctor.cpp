#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/check/judge_system.h"
#include "apps/cli/commands.h"
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

void print(const Finding& finding) {
  fmt::print("{:8} {:18}  {}\n", name_of(finding.state), finding.name, finding.what);
  if (!finding.command.empty()) fmt::print("{:29}{}\n", "", finding.command);
}

int run_doctor(bool json) {
  const auto priority = try_priority();
  const auto memory = lock_memory();
  const auto findings = judge_system(read_system(), priority, memory);
  const auto warnings = std::count_if(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.state == Finding::State::Warn;
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
  auto* command = app.add_subcommand("doctor", "Is this system fit for short delays, and what mends it");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "for machines");
  command->footer(
      "Example:\n  tactus doctor\nIt changes nothing; each finding is followed by the command that fixes it, "
      "or "
      "that shows more.\nExit code 1: something warns.");
  command->callback([json, &exit_code] { exit_code = run_doctor(*json); });
}

}  // namespace tactus::app
