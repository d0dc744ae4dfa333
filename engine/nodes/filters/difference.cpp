#include "engine/nodes/filters/difference_kernel.h"
#include "engine/nodes/filters/filter_ports.h"
#include "engine/nodes/filters/filters.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class DifferenceNode : public Node {
 public:
  explicit DifferenceNode(const NodeSetup& setup) : sample_rate_(setup.sample_rate) {}

  void process(const NodeBlock& block) noexcept override {
    const auto in = block.in[0];
    auto state = state_;
    for (int n = 0; n < block.frames; ++n)
      block.out[0][n] = tactus_difference_step(&state, in[n], sample_rate_.value);
    state_ = state;
  }

  void reset() noexcept override { state_ = {}; }

  std::optional<std::complex<double>> response(int, int, std::complex<double> z,
                                               std::span<const double>) const override {
    return (1.0 - 1.0 / z) * sample_rate_.value;
  }

 private:
  Hertz sample_rate_;
  tactus_difference state_{};
};

}  // namespace

const NodeType& difference_type() {
  static const NodeType type{
      .name = "difference",
      .group = "filters",
      .summary = "The rate of change from frame to frame.",
      .equation = "out = (in - in1) fs, in1 = 0 before the first frame",
      .source = "backward difference",
      .example = "{ type = \"difference\", in = \"position\" }",
      .inputs = {filtered_input("signal, usually a position")},
      .outputs = {{.name = "out", .unit = "=in/s", .doc = "rate of change, half a frame late"}},
      .make = make_node<DifferenceNode>};
  return type;
}

}  // namespace tactus
