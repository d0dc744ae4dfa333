#pragma once

// Thread: [control]
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/nodes/world/world_elements.h"

namespace tactus {

/// An element of `[worlds.x]` with its names resolved. Numbers are not known yet.
struct WorldElement {
  const WorldElementType* type = nullptr;
  std::string name;
  std::array<int, 2> ends = {-1, -1};  ///< elements: `on`, `against`
  std::vector<int> ports;              ///< input of each field, in the order of the type; -1: not in the file
  std::vector<SettingValue> settings;  ///< in the order of the type
  int first_output = 0;

  /// -1: not in the file, or not of this type.
  int port(std::string_view field) const;
  bool chosen(std::string_view setting, std::string_view word) const;
  /// Of a setting of three numbers; nothing where it is left out.
  std::optional<std::array<double, 3>> vector(std::string_view setting) const;
  /// Its number says which bodies it acts on.
  bool acts_on_any() const;
  bool collides() const;
  /// It moves when something acts on it.
  bool moves() const;
};

/// `[worlds.x]` with its names resolved.
struct WorldLayout {
  std::vector<WorldElement> elements;
  double rate_hz = 1000;
  bool direct = true;
  int iterations = 20;
  int contacts = 0;  ///< 0: not in the file
  double erp = 0.2, cfm = 0;
  std::optional<double> stiffness, damping;  ///< instead of erp and cfm
  double bounce_speed = 0.01;
  std::optional<double> correction_speed;
};

/// Errors, all in one go: unknown types, keys and elements; ends that are missing or of the wrong kind;
/// options out of their range. `WorldElement::ports` and `first_output` are filled later.
Checked<WorldLayout> read_world_layout(const NetworkSpec& spec);

}  // namespace tactus
