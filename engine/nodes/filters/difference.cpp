#include "engine/nodes/filters/difference_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

struct DifferenceNode final : KernelNode<tactus_difference_step, 1> {
  using KernelNode::KernelNode;
  std::optional<std::complex<double>> response(int, int, std::complex<double> z,
                                               std::span<const double>) const override {
    return (1.0 - 1.0 / z) * further_;
  }
};

}  // namespace

NodeType difference_type() {
  return {.name = "difference",
          .summary = "Rate of change from frame to frame.",
          .equation = "out = (in - in1) fs, in1 = 0 before the first frame",
          .source = "backward difference",
          .example = "{ type = \"difference\", in = \"position\" }",
          .inputs = {filtered_input("signal, usually a position")},
          .outputs = {{"out", "=in/s", "rate of change, delayed by half a frame"}},
          .make = make_node<DifferenceNode>};
}

}  // namespace tactus
