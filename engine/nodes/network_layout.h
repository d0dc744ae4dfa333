#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/spec.h"
#include "engine/nodes/network_elements.h"
#include "engine/physics/network.h"

namespace tactus {

/// `[networks.x]` with its words understood: which element is joined to which. Numbers are not known yet.
struct NetworkLayout {
  struct Element {
    const ElementType* type = nullptr;
    std::string name;
    std::array<int, 2> ends = {-1, -1};  ///< elements, in the order of `between`, or `on` and `against`
    std::vector<int> ports;  ///< input of each field, in the order of the type; -1: not in the file
  };
  std::vector<Element> elements;
  Solver solver = Solver::Passive;
  int oversample = 1;
};

/// [control] Errors, all in one go: unknown types, keys and elements; ends that are missing, too many, or of
/// the wrong kind; options out of their range. `ports` is filled later.
Checked<NetworkLayout> read_network_layout(const NetworkSpec& spec);

}  // namespace tactus
