#pragma once

// Thread: [realtime] what engine/graph/node.h says so; constructors [control].

#include <array>
#include <memory>

#include "engine/dsp/filters/linear_filter.h"
#include "engine/graph/node_type.h"
#include "engine/nodes/filters/wide_filter_node.h"
#include "engine/nodes/group_steps.h"

namespace tactus {

/// A LinearFilter as a node. Inputs: `in`, then the parameters of its design. Outputs: the filtered signal
/// and, where the type declares a second one, what the filter took away: in - filtered. May skip unread
/// outputs.
template <int Order, std::size_t ParameterCount>
class FilterNode : public Node {
 public:
  using Parameters = std::array<double, ParameterCount>;
  using Design = FilterCoefficients<Order> (*)(const Parameters&, Hertz sample_rate);

  FilterNode(const NodeSetup& setup, Design design)
      : design_(design), sample_rate_(setup.sample_rate), has_rest_(setup.type->outputs.size() > 1) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames == 1)
      process_single(block);
    else
      process_row(block);
  }

  void reset() noexcept override {
    filter_.reset();
    steps_.reset();
    designed_ = false;
  }

  std::optional<std::complex<double>> response(int input, int output, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != 0) return std::nullopt;
    Parameters parameters;
    std::copy_n(at.begin() + 1, ParameterCount, parameters.begin());
    const auto filtered = design_(parameters, sample_rate_).response(1.0 / z);
    return output == 0 ? filtered : 1.0 - filtered;
  }

  std::unique_ptr<Node> vectorised(std::span<const Node* const>) const override {
    return std::make_unique<WideFilterNode<Order, ParameterCount>>(design_, sample_rate_, has_rest_);
  }

  static MakeNode maker(Design design) {
    return [design](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
      return std::make_unique<FilterNode>(setup, design);
    };
  }

 private:
  void process_single(const NodeBlock& block) noexcept {
    const double x = *block.in[0].data;
    const int position = steps_.single(block, [&] { update(block, 0); });
    const double y = filter_.run_single(x, position);
    if (block.out[0] != nullptr) *block.out[0] = y;
    if (has_rest_ && block.out[1] != nullptr) *block.out[1] = x - y;
  }

  // Not inlined: what many frames need to be set up would delay a single one.
  [[gnu::noinline]] void process_row(const NodeBlock& block) noexcept {
    InARow in_a_row;
    const double* x = in_a_row(block.in[0], block.frames);
    std::array<double, kMaxSubBlock> unread;
    double* y = block.out[0] != nullptr ? block.out[0] : unread.data();
    steps_.go(
        block, rest(block, 1, ParameterCount), [&](int frame) { update(block, frame); },
        [&](int from, int to, int position) { filter_.run(x + from, y + from, to - from, position); });
    if (!has_rest_ || block.out[1] == nullptr) return;
    for (int n = 0; n < block.frames; ++n) block.out[1][n] = x[n] - y[n];
  }

  void update(const NodeBlock& block, int frame) noexcept {
    Parameters now;
    for (std::size_t i = 0; i < ParameterCount; ++i) now[i] = block.in[i + 1][frame];
    if (designed_ && now == parameters_) return;
    parameters_ = now;
    designed_ = true;
    filter_.design(design_(now, sample_rate_));
  }

  Design design_;
  Hertz sample_rate_;
  bool has_rest_;
  bool designed_ = false;
  Parameters parameters_{};
  GroupSteps steps_;
  LinearFilter<Order> filter_;
};

/// A design that depends on a cutoff alone, the first parameter.
template <tactus_filter_design (*Shape)(double radians)>
FilterCoefficients<1> of_cutoff(const std::array<double, 1>& parameters, Hertz sample_rate) {
  return FilterCoefficients<1>{Shape(tactus_filter_radians(parameters[0], sample_rate.value))};
}

}  // namespace tactus
