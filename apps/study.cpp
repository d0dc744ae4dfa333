#include <fmt/format.h>

#include "apps/commands.h"
#include "apps/study/study_commands.h"

namespace tactus::app {

void add_study(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("study", "Studies of a scene: numbers, tables and pictures");
  command->require_subcommand(0, 1);
  add_study_work_precision(*command, exit_code);
  command->footer(
      "Examples:\n  tactus study work-precision instruments/numerics/woofer\n"
      "docs/numerics.md says what came of the scenes that ship.");
  command->callback([command] {
    if (command->get_subcommands().empty()) fmt::print("{}", command->help("tactus"));
  });
}

}  // namespace tactus::app
