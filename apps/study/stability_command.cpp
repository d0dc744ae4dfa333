#include <array>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/study/reports.h"
#include "apps/study/sweep_options.h"

namespace tactus::app {
namespace {

struct DeviceOption {
  const char *name, *unit;
  double least;
  double WallDevice::*value;
  const char* help;
};
constexpr std::array<DeviceOption, 5> kDeviceOptions = {
    {{"mass", "kg", 1e-6, &WallDevice::mass, "moving mass of the device, such as \"9 g\""},
     {"damping", "N s/m", 0, &WallDevice::damping, "viscous damping of the device, such as \"0.05 N s/m\""},
     {"friction", "N", 0, &WallDevice::friction, "dry friction of the device, such as \"0.2 N\""},
     {"step", "m", 0, &WallDevice::quantum, "step of the position encoder, such as \"0.157 mm\""},
     {"force-limit", "N", 1e-3, &WallDevice::force_limit, "largest force of the motor, such as \"6.37 N\""}}};

struct StabilityOptions : RunOptions {
  std::array<std::string, kDeviceOptions.size()> device;
  std::string rate, wall_damping;
  int points = 8;
};

/// A finger on the tip: Hajian & Howe, J. Biomechanical Engineering 119, 1997, as a range of magnitudes.
constexpr double kLightMass = 5e-3, kFirmMass = 10e-3;     // [kg]
constexpr double kLightDamping = 1.0, kFirmDamping = 5.0;  // [N s/m]

/// The device and the loop of the options and the scene.
Checked<WallStudy> study_of(const StabilityOptions& options) {
  WallStudy study;
  study.controllers = controllers_of_the_paper();
  study.points_per_decade = options.points;
  SceneDevice device{.bare = {.quantum = 0.15708e-3, .force_limit = 6.37}};
  if (!options.target.empty()) {
    const auto scene = load_target(options);
    if (!scene) return tl::unexpected(scene.error());
    const auto described = device_of(*scene);
    if (!described) return tl::unexpected(std::vector{described.error()});
    device = *described;
    study.rate = scene->rate;
    study.controllers.push_back({"this scene", scene->rate, scene->delay, 0});
  }
  std::vector<Error> errors;
  const auto read = [&](const std::string& text, const char* unit, const char* name, double least,
                        double& value) {
    const auto status = read_option(text, unit, name, least, 1e9, value);
    if (!status) errors.push_back(status.error());
  };
  for (std::size_t i = 0; i < kDeviceOptions.size(); ++i) {
    const auto& option = kDeviceOptions[i];
    read(options.device[i], option.unit, option.name, option.least, device.bare.*option.value);
  }
  read(options.wall_damping, "N s/m", "wall-damping", 0, study.damping);
  read(options.rate, "Hz", "rate", 100, study.rate.value);
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  study.devices = {{"bare", device.bare}, {"held lightly", device.bare.held(kLightMass, kLightDamping)}};
  if (device.hand_damping > 0) study.devices.push_back({"in this scene", device.held()});
  study.devices.push_back({"held firmly", device.bare.held(kFirmMass, kFirmDamping)});
  return study;
}

int run_stability(const StabilityOptions& options) {
  const auto study = study_of(options);
  if (!study) return report(study.error());
  RunPlan plan;
  if (const auto status = read_run_plan(options, plan); !status) return report(status.error());
  SweepMonitor monitor{"walls", plan};
  const auto map = map_walls(*study, plan);
  if (!map) return report(map.error());
  if (const auto exit = monitor.end(map->finished, map->runs)) return *exit;
  if (const int failed = publish(options, app::text_of(*map), app::json_of(*map), app::plots_of(*map)))
    return failed;
  return map->confirmed == map->borders ? kDone : kNo;
}

}  // namespace

void add_study_stability(CLI::App& study, int& exit_code) {
  auto* command = study.add_subcommand(
      "stability",
      "Stiffest stable virtual wall against delay and sample rate, with and without a finger on the device");
  auto options = std::make_shared<StabilityOptions>();
  add_study_options(
      *command, *options,
      "scene whose plant describes the device by its controls mass, damping, friction, step and force_limit; "
      "default: 50 g, 0.1 N s/m, no friction, encoder steps of 0.157 mm, 6.37 N");
  for (std::size_t i = 0; i < kDeviceOptions.size(); ++i)
    command->add_option(std::string{"--"} + kDeviceOptions[i].name, options->device[i],
                        kDeviceOptions[i].help);
  command->add_option(
      "--wall-damping", options->wall_damping,
      "damping of the walls (velocity as the difference of positions), such as \"0.1 N s/m\"");
  command->add_option("--rate", options->rate,
                      "sample rate of the curves against delay; default: the scene's, or 20 kHz");
  command->add_option("--points", options->points, "points of each curve per decade")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  add_run_options(*command, *options);
  command->footer(
      "Examples:\n  tactus study stability instruments/wall --report walls.svg\n"
      "  tactus study stability --mass \"20 g\" --damping \"0.3 N s/m\" --rate \"8 kHz\"\n"
      "docs/walls.md explains the stability map. Exit code 1: a stability limit was not confirmed by "
      "simulation. 5: interrupted.");
  command->callback([options, &exit_code] { exit_code = run_stability(*options); });
}

}  // namespace tactus::app
