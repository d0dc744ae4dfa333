#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/writable.h"
#include "apps/study/study_commands.h"
#include "apps/study/wall_report.h"
#include "engine/study/walls/wall_device.h"

namespace tactus::app {
namespace {

struct StabilityOptions {
  std::string target, mass, damping, friction, step, force_limit, rate, wall_damping, picture;
  int points = 8;
  bool json = false;
};

/// A finger on the tip: Hajian & Howe, J. Biomechanical Engineering 119, 1997, as a range of magnitudes.
constexpr double kLightMass = 5e-3, kFirmMass = 10e-3;     // [kg]
constexpr double kLightDamping = 1.0, kFirmDamping = 5.0;  // [N s/m]

/// "9 g" into `value`, if it was given. Errors: of the text; OutOfRange below `least`.
Status take(const std::string& text, const char* unit, const char* name, double least, double& value) {
  if (text.empty()) return {};
  const auto given = parse_option(text, unit, name);
  if (!given) return tl::unexpected(given.error());
  if (!(*given >= least) || !std::isfinite(*given))
    return fail(Errc::OutOfRange, std::string{"--"} + name,
                "must be at least " + fmt::format("{:g} {}", least, unit), "");
  value = *given;
  return {};
}

MappedDevice held(const WallDevice& bare, const std::string& name, double mass, double damping) {
  auto device = bare;
  device.mass += mass;
  device.damping += damping;
  return {name, device};
}

/// The device and the loop that the options and the scene say.
Checked<WallStudy> study_of(const StabilityOptions& options) {
  WallStudy study;
  study.controllers = controllers_of_the_paper();
  study.points_per_decade = options.points;
  WallDevice bare{.mass = 0.05, .damping = 0.1, .quantum = 0.15708e-3, .force_limit = 6.37};
  std::optional<SceneDevice> scene_device;
  if (!options.target.empty()) {
    const auto file = resolve_target(options.target, "scene.toml");
    const auto scene = load_scene(file, root_of(file));
    if (!scene) return tl::unexpected(scene.error());
    const auto device = device_of(*scene);
    if (!device) return tl::unexpected(std::vector{device.error()});
    scene_device = *device;
    bare = device->bare;
    study.rate = scene->rate;
    study.controllers.push_back({"this scene", scene->rate, scene->delay, 0});
  }
  double rate = study.rate.value;
  std::vector<Error> errors;
  for (const auto& status : {take(options.mass, "kg", "mass", 1e-6, bare.mass),
                             take(options.damping, "N s/m", "damping", 0, bare.damping),
                             take(options.friction, "N", "friction", 0, bare.friction),
                             take(options.step, "m", "step", 0, bare.quantum),
                             take(options.force_limit, "N", "force-limit", 1e-3, bare.force_limit),
                             take(options.wall_damping, "N s/m", "wall-damping", 0, study.damping),
                             take(options.rate, "Hz", "rate", 100, rate)})
    if (!status) errors.push_back(status.error());
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  study.rate = Hertz{rate};
  study.devices = {{"bare", bare},
                   held(bare, "held lightly", kLightMass, kLightDamping),
                   held(bare, "held firmly", kFirmMass, kFirmDamping)};
  if (scene_device && scene_device->hand_damping > 0)
    study.devices.insert(study.devices.begin() + 2,
                         held(bare, "in this scene", scene_device->hand_mass, scene_device->hand_damping));
  return study;
}

int run_stability(const StabilityOptions& options) {
  const auto study = study_of(options);
  if (!study) return report(study.error());
  std::optional<Progress> progress{"walls"};
  const auto map = map_walls(*study, [&](double share) { (*progress)(share); });
  progress.reset();
  if (!options.picture.empty())
    if (const auto written = write_svg(options.picture, picture_of(map)); !written)
      return report(written.error());
  if (options.json)
    fmt::print("{}\n", json_of(map).dump(2));
  else
    fmt::print("{}", text_of(map));
  if (!options.picture.empty() && !options.json) fmt::print("{}: the map\n", options.picture);
  return map.confirmed() == map.borders() ? kDone : kNo;
}

}  // namespace

void add_study_stability(CLI::App& study, int& exit_code) {
  auto* command =
      study.add_subcommand("stability", "The stiffest virtual wall over delay and rate, bare and held");
  auto options = std::make_shared<StabilityOptions>();
  command->add_option("SCENE", options->target,
                      "its plant's controls mass, damping, friction, step and force_limit say what the walls "
                      "push; [50 g, 0.1 N s/m, 6.37 N, steps of 0.157 mm]");
  command->add_option("--mass", options->mass, "of the device, such as \"9 g\"");
  command->add_option("--damping", options->damping, "of its own, such as \"0.05 N s/m\"");
  command->add_option("--friction", options->friction, "dry, such as \"0.2 N\"");
  command->add_option("--step", options->step, "of the encoder, such as \"0.157 mm\"");
  command->add_option("--force-limit", options->force_limit, "of the motor, such as \"6.37 N\"");
  command->add_option("--wall-damping", options->wall_damping,
                      "of the walls, by differences of the position, such as \"0.1 N s/m\"");
  command->add_option("--rate", options->rate, "of the walls over the delay; [the scene's, or 20 kHz]");
  command->add_option("--points", options->points, "a decade")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option("--report", options->picture, "the map, an SVG file")->check(writable_file());
  command->add_flag("--json", options->json, "for machines");
  command->footer(
      "Examples:\n  tactus study stability instruments/wall --report walls.svg\n"
      "  tactus study stability --mass \"20 g\" --damping \"0.3 N s/m\" --rate \"8 kHz\"\n"
      "docs/walls.md says how to read the map. Exit code 1: a border was not confirmed by simulation.");
  command->callback([options, &exit_code] { exit_code = run_stability(*options); });
}

}  // namespace tactus::app
