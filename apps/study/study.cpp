#include "apps/study/study.h"

namespace tactus::app {

void add_study(CLI::App& app, int& exit_code) {
  auto& group = add_command_group(
      app, "study", "Run a predefined study: work-precision, playability, stability, bifurcation",
      "Examples:\n  tactus study work-precision instruments/numerics/woofer\n  tactus study playability "
      "instruments/haptic_drum\n  tactus study stability instruments/wall --svg walls.svg\n  tactus study "
      "bifurcation instruments/bouncing_ball --svg ball.svg\nHelp on a study:  tactus study stability "
      "--help");
  for (auto* add :
       {add_study_work_precision, add_study_playability, add_study_stability, add_study_bifurcation})
    add(group, exit_code);
}

}  // namespace tactus::app
