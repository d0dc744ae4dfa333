#include <fmt/format.h>

#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/writable.h"
#include "apps/study/bifurcation_report.h"
#include "apps/study/study_commands.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

struct BifurcationOptions {
  std::string target, picture;
  BifurcationPlan plan;
  double restitution = 0;
  bool json = false;
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
  const auto file = resolve_target(options.target, "scene.toml");
  const auto scene = load_scene(file, root_of(file));
  if (!scene) return report(scene.error());
  if (plan.control.empty()) plan.control = default_control(*scene);
  std::optional<Progress> progress{std::in_place, "sweeping " + scene->name};
  const auto study =
      study_bifurcation(*scene, standard_nodes(), plan, [&](double share) { (*progress)(share); });
  progress.reset();
  if (!study) return report(study.error());
  if (!options.picture.empty())
    if (const auto written = write_svg(options.picture, picture_of(*study)); !written)
      return report(written.error());
  if (options.json)
    fmt::print("{}\n", json_of(*study).dump(2));
  else
    fmt::print("{}", text_of(*study));
  if (!options.picture.empty() && !options.json) fmt::print("{}: the diagram\n", options.picture);
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
  command->add_option("SCENE", options->target, "its plant gives out 'ball' and 'table'")->required();
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
  command->add_option("--report", options->picture, "the diagram, an SVG file")->check(writable_file());
  command->add_flag("--json", options->json, "for machines");
  command->footer(
      "Examples:\n  tactus study bifurcation instruments/bouncing_ball --report ball.svg\n"
      "  tactus study bifurcation instruments/bouncing_ball/table_scene.toml --from 1.3 --to 1.75 --values "
      "91\n"
      "Exit code 1: the ball never landed once a period.");
  command->callback([options, &exit_code] { exit_code = run_bifurcation(*options); });
}

}  // namespace tactus::app
