#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/graph/plan/schedule.h"

namespace tactus {

/// A schedule in terms that hold for another version of the same file as well: who reads what, by name.
struct Anatomy {
  /// What stands at an operand: the name of what feeds it ("input x", "node bridge.loss:0"), or a constant.
  struct Operand {
    int slot = -1;  ///< in Schedule::inputs, or -1
    std::string source;
    std::optional<double> constant;
  };
  /// A node, or one operation of an expression.
  struct Part {
    std::string name;
    int node = -1;
    std::uint64_t made_from = 0;  ///< fingerprint of a node, operator of an operation
    int pace = 0;                 ///< of its operands, in Schedule::paces
    std::vector<Operand> operands;
  };

  std::vector<Part> parts;
  std::map<std::string, std::size_t> index;  ///< [name] in `parts`
  std::vector<Operand> channels;             ///< as Schedule::channels
};

/// [control] The name of the part that a source belongs to is what stands before the ':'.
Anatomy anatomy(const Schedule& schedule);

}  // namespace tactus
