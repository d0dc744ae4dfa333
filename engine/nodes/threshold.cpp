#include "engine/nodes/threshold.h"

#include <algorithm>

#include "engine/dsp/comparator.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Threshold final : public Node {
 public:
  explicit Threshold(const NodeSetup&) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal in = block.in[0], level = block.in[1], hysteresis = block.in[2];
    for (int i = 0; i < block.frames; ++i) {
      const bool fired = comparator_.step(in[i], level[i], std::max(0.0, hysteresis[i]));
      block.out[0][i] = fired ? 1 : 0;
      block.out[1][i] = comparator_.high ? 1 : 0;
    }
  }
  void reset() noexcept override { comparator_ = {}; }

 private:
  Comparator comparator_;
};

}  // namespace

const NodeType& threshold_type() {
  static const NodeType type = {
      .name = "threshold",
      .group = "logic",
      .summary =
          "Triggers when a signal reaches a level, and again only after it fell below it by the hysteresis.",
      .equation =
          "high from in >= level until in < level - hysteresis; out = 1 in the first frame that is high",
      .source = "Schmitt, J. Sci. Instrum. 15, 1938",
      .example =
          "touched = { type = \"threshold\", in = \"pressure\", level = \"0.5 N\", hysteresis = \"0.1 N\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal", .fallback = {}},
                 {.name = "level", .unit = "=in", .doc = "level to reach", .fallback = {}},
                 {.name = "hysteresis",
                  .unit = "=in",
                  .doc = "how far below `level` it lets go",
                  .fallback = 0,
                  .low = 0}},
      .outputs = {{.name = "out",
                   .unit = "",
                   .doc = "fires at the rise",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  {.name = "gate", .unit = "", .doc = "1 while high", .range = {0, 1}}},
      .settings = {},
      .make = make_node<Threshold>,
      .range = {},
  };
  return type;
}

}  // namespace tactus
