#include <fmt/format.h>

#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/study/reports.h"
#include "apps/study/sweep_options.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

struct BifurcationOptions : StudyOptions {
  BifurcationPlan plan;
  double restitution = 0;
};

/// A scene without an instrument has its controls in the plant.
std::string default_control(const SceneSpec& scene) {
  return scene.part("instrument") != nullptr ? "gamma" : scene.parts.front().name + ".gamma";
}

int run_bifurcation(const BifurcationOptions& options) {
  auto plan = options.plan;
  if (!(plan.from < plan.to))
    return report(Error{Errc::OutOfRange, "--to", "the sweep goes up, and its end is not above its start",
                        "give --from less than --to"}),
           kUsage;
  if (options.restitution > 0) plan.restitution = options.restitution;
  const auto scene = load_target(options);
  if (!scene) return report(scene.error());
  if (plan.control.empty()) plan.control = default_control(*scene);
  const auto study = [&] {
    Progress progress{"sweeping " + scene->name};
    return study_bifurcation(*scene, standard_nodes(), plan, [&](double share) { progress(share); });
  }();
  if (!study) return report(study.error());
  if (const int failed = publish(options, text_of(*study), json_of(*study), plots_of(*study))) return failed;
  return study->measured_restitution > 0 ? kDone : kNo;
}

}  // namespace

void add_study_bifurcation(CLI::App& study, int& exit_code) {
  auto* command = study.add_subcommand(
      "bifurcation", "Orbits of a ball on a driven table over a control, beside the ideal ball");
  auto options = std::make_shared<BifurcationOptions>();
  auto& plan = options->plan;
  plan.from = 0.9;
  plan.to = 1.6;
  add_study_options(*command, *options, "scene with the roles 'ball' and 'table'")->required();
  command->add_option("--control", plan.control, "such as gamma, or plant.gamma of another part; [gamma]");
  command->add_option("--from", plan.from, "first value, SI")->capture_default_str();
  command->add_option("--to", plan.to, "last value, SI")->capture_default_str();
  command->add_option("--values", plan.values, "how many")->check(CLI::Range(3, 2000))->capture_default_str();
  command->add_option("--settle", plan.settling_s, "seconds at each value before anything is read")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  command->add_option("--read", plan.reading_s, "seconds of landings at each value")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command->add_option("--restitution", options->restitution, "of the ideal ball; [as measured]")
      ->check(CLI::Range(0.01, 0.99));
  command->footer(
      "Examples:\n  tactus study bifurcation instruments/bouncing_ball --report ball.svg\n"
      "  tactus study bifurcation instruments/bouncing_ball/table_scene.toml --from 1.3 --to 1.75 --values "
      "91\n"
      "Exit code 1: the ball never landed once a period.");
  command->callback([options, &exit_code] { exit_code = run_bifurcation(*options); });
}

}  // namespace tactus::app
