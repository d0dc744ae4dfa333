#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/physics/network.h"

namespace tactus {

/// `[networks.x]` with its words understood: which element is joined to which. Numbers are not known yet.
struct NetworkLayout {
  struct Element {
    const ElementType* type = nullptr;
    std::string name;
    std::array<int, 2> ends = {-1, -1};  ///< elements, in the order of `between`, or `on` and `against`
    std::array<int, 2> within = {0, 0};  ///< which of their points
    std::vector<int> ports;  ///< input of each field, in the order of the type; -1: not in the file
    std::vector<SettingValue> settings;  ///< in the order of the type
    int normal_link = -1;                ///< of a friction: the element whose force presses

    /// Of chains, rings and grids; else 1. Rows are 1 but for grids.
    int rows() const;
    int columns() const;
    int points() const { return rows() * columns(); }
    bool chosen(std::string_view setting, std::string_view word) const;
  };
  std::vector<Element> elements;
  Solver solver = Solver::Passive;
  int oversample = 0;  ///< 0: not in the file
};

/// [control] Errors, all in one go: unknown types, keys and elements; ends that are missing, too many, or of
/// the wrong kind; options out of their range. `ports` is filled later.
Checked<NetworkLayout> read_network_layout(const NetworkSpec& spec);

}  // namespace tactus
