#include "engine/study/walls/wall_device.h"

#include <string>

#include "engine/core/named.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

struct DeviceControl {
  const char *name, *unit;
  double* value;
  bool required;
};

/// What a control is set to. Nothing where the plant has none of that name.
Result<std::optional<double>> setting_of(const ScenePart& plant, const DeviceControl& expected) {
  const auto* control = find_named(plant.graph->controls, expected.name);
  if (control == nullptr) return std::nullopt;
  const auto* wire = find(plant.wires, expected.name);
  if (wire == nullptr) {
    ErrorList reported_elsewhere;
    return std::optional{read_control(*control, reported_elsewhere).control.value};
  }
  const auto number = read_quantity(*wire, parse_unit(expected.unit).value_or(Unit{}), expected.name);
  if (number) return std::optional{*number};
  return fail(Errc::WrongType, wire->at.text(),
              std::string{"'"} + expected.name + "' of the plant must be a quantity for this study",
              std::string{"write "} + expected.name + " = \"" + "1 " + expected.unit + "\"");
}

}  // namespace

WallDevice SceneDevice::held() const {
  auto device = bare;
  device.mass += hand_mass;
  device.damping += hand_damping;
  return device;
}

Result<SceneDevice> device_of(const SceneSpec& scene) {
  SceneDevice device;
  auto& bare = device.bare;
  const auto* plant = scene.part("plant");
  for (const auto& expected : {DeviceControl{"mass", "kg", &bare.mass, true},
                               {"damping", "N s/m", &bare.damping, true},
                               {"friction", "N", &bare.friction, false},
                               {"step", "m", &bare.quantum, false},
                               {"force_limit", "N", &bare.force_limit, false},
                               {"hand_mass", "kg", &device.hand_mass, false},
                               {"hand_damping", "N s/m", &device.hand_damping, false}}) {
    const auto setting = setting_of(*plant, expected);
    if (!setting) return tl::unexpected(setting.error());
    if (*setting)
      *expected.value = **setting;
    else if (expected.required)
      return fail(Errc::Missing, plant->at.text(),
                  std::string{"the plant has no control '"} + expected.name + "'",
                  "give the device with --mass and --damping instead of a scene");
  }
  return device;
}

}  // namespace tactus
