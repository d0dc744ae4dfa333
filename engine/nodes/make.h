#pragma once

#include <algorithm>
#include <array>
#include <memory>

#include "engine/graph/node_type.h"

namespace tactus {

/// [control] `make` of a node type whose class is constructed from the setup and cannot fail.
template <class SomeNode>
Result<std::unique_ptr<Node>> make_node(const NodeSetup& setup) {
  return std::make_unique<SomeNode>(setup);
}

/// [realtime] A node of one output whose kernel goes frame by frame. `Kernel` is constructed from the setup
/// and has `static constexpr int kInputs`, `double step(const double* in)` with the inputs in the order of
/// their declaration, and `state`, which is all zero at the start.
template <class Kernel>
class KernelNode : public Node {
 public:
  explicit KernelNode(const NodeSetup& setup) : kernel_(setup) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames > 1) return process_row(block);
    std::array<double, kInputs> in;
    for (std::size_t k = 0; k < kInputs; ++k) in[k] = *block.in[k].data;
    *block.out[0] = kernel_.step(in.data());
  }
  void reset() noexcept override { kernel_.state = {}; }

 private:
  static constexpr auto kInputs = static_cast<std::size_t>(Kernel::kInputs);

  // Not inlined: the setup for many frames would delay a single one.
  [[gnu::noinline]] void process_row(const NodeBlock& block) noexcept {
    std::array<Signal, kInputs> signals;
    std::copy_n(block.in, kInputs, signals.begin());
    double* const out = block.out[0];
    Kernel kernel = kernel_;  // in registers: `out` could overlap a member
    for (int n = 0, frames = block.frames; n < frames; ++n) {
      std::array<double, kInputs> in;
      for (std::size_t k = 0; k < kInputs; ++k) in[k] = signals[k][n];
      out[n] = kernel.step(in.data());
    }
    kernel_ = kernel;
  }

  Kernel kernel_;
};

}  // namespace tactus
