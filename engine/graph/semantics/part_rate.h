#pragma once

// Thread: [control].

#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/spec.h"

namespace tactus {

/// How a part runs at a fraction of the rate around it:
///
///   loop = { use = "loop.toml", rate = "1/16", take = "mean", between = "line", … }
struct PartRate {
  static constexpr int kSlowest = 1024;
  int ratio = 1;      ///< frames around it for one of its own
  bool mean = false;  ///< its inputs are means of the frames since its last one; else what there is
  bool line = false;  ///< its outputs go straight from one sample to the next; else they are held
};

/// [control] What `rate`, `take` and `between` of a part say; `around` is the rate of the file that uses it.
PartRate read_part_rate(const NodeSpec& node, const GraphSpec& part, Hertz around, Mistakes& mistakes);

/// [control] The fields of a part that say how it runs and are no wires. An input or a control of the part
/// that is called like a word about its rate comes before that word.
std::vector<std::string> part_words(const GraphSpec& part);

}  // namespace tactus
