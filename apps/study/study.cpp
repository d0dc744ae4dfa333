#include <fmt/format.h>

#include "apps/cli/commands.h"
#include "apps/study/sweep_options.h"

namespace tactus::app {

void add_study(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("study", "Run a sweep with a verdict: playability, stability, accuracy");
  command->require_subcommand(0, 1);
  add_study_work_precision(*command, exit_code);
  add_study_playability(*command, exit_code);
  add_study_stability(*command, exit_code);
  add_study_bifurcation(*command, exit_code);
  command->footer(
      "Examples:\n  tactus study work-precision instruments/numerics/woofer\n"
      "  tactus study playability instruments/haptic_drum\n"
      "  tactus study stability instruments/wall --report walls.svg\n"
      "  tactus study bifurcation instruments/bouncing_ball --report ball.svg\n"
      "Help on a study:  tactus study stability --help");
  command->callback([command] {
    if (command->get_subcommands().empty()) fmt::print("{}", command->help("tactus"));
  });
}

}  // namespace tactus::app
