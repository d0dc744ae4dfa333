#pragma once

// Thread: [realtime] what engine/graph/node.h says so; constructors [control].

#include <array>
#include <memory>

#include "engine/dsp/filters/linear_filter.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/process.h"

namespace tactus {

/// A LinearFilter as a node, or eight of them in vector registers. Inputs: `in`, then the parameters of its
/// design. Outputs: the filtered signal and, where the type declares a second one, what the filter took away:
/// in - filtered. May skip unread outputs.
template <int Order, std::size_t ParameterCount, int Width = 1>
class FilterNode : public Node {
 public:
  using Parameters = std::array<double, ParameterCount>;
  using Design = tactus_filter_design (*)(const Parameters&, Hertz sample_rate);

  FilterNode(Design design, Hertz sample_rate, bool has_remainder)
      : design_(design), sample_rate_(sample_rate), has_remainder_(has_remainder) {}

  void process(const NodeBlock& block) noexcept override {
    if constexpr (Width == 1)
      if (block.frames == 1) return process_single(block);
    process_frames(block);
  }

  void reset() noexcept override {
    filter_.reset();
    steps_.reset();
    designed_ = false;
  }
  void copy(const Node& other) noexcept override { assign(*this, other); }

  std::optional<std::complex<double>> response(int input, int output, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != 0) return std::nullopt;
    Parameters parameters;
    std::copy_n(at.begin() + 1, ParameterCount, parameters.begin());
    const auto filtered = filter_response(design_(parameters, sample_rate_), 1.0 / z);
    return output == 0 ? filtered : 1.0 - filtered;
  }

  std::unique_ptr<Node> vectorised(std::span<const Node* const>) const override {
    return std::make_unique<FilterNode<Order, ParameterCount, kVectorWidth>>(design_, sample_rate_,
                                                                             has_remainder_);
  }

  static MakeNode maker(Design design) {
    return [design](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
      return std::make_unique<FilterNode>(design, setup.sample_rate, setup.type->outputs.size() > 1);
    };
  }

 private:
  // Neither is inlined: what one prepares would delay the other.
  [[gnu::noinline]] void process_single(const NodeBlock& block) noexcept {
    const double x = *block.in[0].data;
    const int position = steps_.single(block, [&](int frame) { update(block, frame); });
    const double y = filter_.run_single(x, position);
    if (block.out[0] != nullptr) *block.out[0] = y;
    if (has_remainder_ && block.out[1] != nullptr) *block.out[1] = x - y;
  }

  [[gnu::noinline]] void process_frames(const NodeBlock& block) noexcept {
    if constexpr (Width == 1)
      if (block.in[0].stride == 1 && block.out[0] != nullptr && group_position(block.first_frame) == 0 &&
          rests(block)) {
        filter_.run(block.in[0].data, block.out[0], block.frames, 0);
        return take_remainder(block, block.in[0].data, block.out[0]);
      }
    process_changing(block);
  }

  /// The filter is the one that the parameters ask for, in every frame.
  bool rests(const NodeBlock& block) const noexcept {
    bool rests = designed_;
    for (std::size_t i = 0; i < ParameterCount; ++i)
      rests = rests && block.in[i + 1].constant() && *block.in[i + 1].data == parameters_[0][i];
    return rests;
  }

  [[gnu::noinline]] void process_changing(const NodeBlock& block) noexcept {
    Contiguous contiguous;
    const auto x = run_input<Width>(block, contiguous);
    std::array<double, static_cast<std::size_t>(kMaxSubBlock * Width)> unread;
    double* y = block.out[0] != nullptr ? block.out[0] : unread.data();
    steps_.run(
        block, all_constant(block, 1, ParameterCount), [&](int frame) { update(block, frame); },
        [&](int from, int to, int position) {
          filter_.run(x + from, y + from * Width, to - from, position);
        });
    take_remainder(block, x, y);
  }

  template <class Input>
  void take_remainder(const NodeBlock& block, const Input& x, const double* y) noexcept {
    if (!has_remainder_ || block.out[1] == nullptr) return;
    for (int n = 0; n < block.frames; ++n)
      if constexpr (Width == 1)
        block.out[1][n] = x[n] - y[n];
      else
        (x[n] - Lanes::load(y + n * Width)).store(block.out[1] + n * Width);
  }

  void update(const NodeBlock& block, int frame) noexcept {
    for (int lane = 0; lane < Width; ++lane) {
      Parameters now;
      for (std::size_t i = 0; i < ParameterCount; ++i)
        now[i] = VectorSignal{block.in[i + 1]}.lane(lane, frame);
      auto& before = parameters_[static_cast<std::size_t>(lane)];
      if (designed_ && now == before) continue;
      before = now;
      filter_.design(design_(now, sample_rate_), lane);
    }
    designed_ = true;
  }

  Design design_;
  Hertz sample_rate_;
  bool has_remainder_;
  bool designed_ = false;
  std::array<Parameters, static_cast<std::size_t>(Width)> parameters_{};
  GroupSteps steps_;
  std::conditional_t<Width == 1, LinearFilter<Order>, VectorFilter<Order>> filter_;
};

/// A design that depends on a cutoff alone, the first parameter.
template <tactus_filter_design (*Shape)(double radians)>
tactus_filter_design of_cutoff(const std::array<double, 1>& parameters, Hertz sample_rate) {
  return Shape(tactus_filter_radians(parameters[0], sample_rate.value));
}

}  // namespace tactus
