#pragma once

// Thread: [realtime] what engine/graph/node.h says so; constructors [control].

#include <algorithm>
#include <array>
#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include "engine/graph/node_type.h"
#include "engine/nodes/wide_signal.h"

namespace tactus {

template <class Law>
class WideElementwiseNode;

/// A node without memory: one output, a function of the inputs of the same frame. A Law may depend on the
/// settings, which all lanes have in common, and on nothing else.
/// `Law` has `static constexpr int kInputs`, `double value(in) const` and `double slope(input, in) const`,
/// where `in` are the inputs' values in declaration order (`value` may take Lanes as well); `slope` is the
/// derivative by one of them, which is the response.
template <class Law>
class ElementwiseNode final : public Node {
 public:
  explicit ElementwiseNode(Law law) : law_(std::move(law)) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames > 1) return process_row(block);
    Values in{};
    for (int k = 0; k < Law::kInputs; ++k) in[k] = *block.in[k].data;
    *block.out[0] = law_.value(in.data());
  }
  void reset() noexcept override {}

  std::unique_ptr<Node> vectorised(std::span<const Node* const>) const override {
    return std::make_unique<WideElementwiseNode<Law>>(law_);
  }

  std::optional<std::complex<double>> response(int input, int, std::complex<double>,
                                               std::span<const double> at) const override {
    return law_.slope(input, at.data());
  }

 private:
  using Values = std::array<double, static_cast<std::size_t>(Law::kInputs)>;

  // Not inlined: what many frames need to be set up would delay a single one.
  [[gnu::noinline]] void process_row(const NodeBlock& block) const noexcept {
    if (only_first_move<1>(block)) return run<1>(block);
    if constexpr (Law::kInputs > 1)
      if (only_first_move<2>(block)) return run<2>(block);
    Values in{};
    for (int i = 0; i < block.frames; ++i) {
      for (int k = 0; k < Law::kInputs; ++k) in[k] = block.in[k][i];
      block.out[0][i] = law_.value(in.data());
    }
  }

  template <int Moving>
  static bool only_first_move(const NodeBlock& block) {
    for (int k = 0; k < Law::kInputs; ++k)
      if (block.in[k].constant() == (k < Moving)) return false;
    return true;
  }

  /// The same function of the same values, where the compiler can see which of them rest.
  template <int Moving>
  void run(const NodeBlock& block) const noexcept {
    double* const out = block.out[0];
    Values in{};
    for (int k = Moving; k < Law::kInputs; ++k) in[k] = block.in[k][0];
    std::array<const double*, Moving> moving;
    for (int k = 0; k < Moving; ++k) moving[k] = block.in[k].data;
    for (int i = 0; i < block.frames; ++i) {
      for (int k = 0; k < Moving; ++k) in[k] = moving[k][i];
      out[i] = law_.value(in.data());
    }
  }

  Law law_;
};

/// `make` of a node type whose law has no settings.
template <class Law>
Result<std::unique_ptr<Node>> make_elementwise(const NodeSetup&) {
  return std::make_unique<ElementwiseNode<Law>>(Law{});
}

/// Eight ElementwiseNodes in one vector register.
template <class Law>
class WideElementwiseNode final : public Node {
 public:
  explicit WideElementwiseNode(Law law) : law_(std::move(law)) {}

  void process(const NodeBlock& block) noexcept override {
    std::array<Signal, kInputs> signals;
    std::copy_n(block.in, kInputs, signals.begin());
    std::array<Lanes, kInputs> in;
    double* out = block.out[0];
    for (int n = 0, frames = block.frames; n < frames; ++n, out += kVectorWidth) {
      for (std::size_t k = 0; k < kInputs; ++k) in[k] = WideSignal{signals[k]}[n];
      value(in).store(out);
    }
  }
  void reset() noexcept override {}

 private:
  static constexpr auto kInputs = static_cast<std::size_t>(Law::kInputs);

  Lanes value(const std::array<Lanes, kInputs>& in) const noexcept {
    if constexpr (requires(const Law& law, const Lanes* lanes) { law.value(lanes); }) {
      return law_.value(in.data());
    } else {
      std::array<std::array<double, kVectorWidth>, kInputs> rows;
      for (std::size_t k = 0; k < kInputs; ++k) in[k].store(rows[k].data());
      std::array<double, kVectorWidth> result;
      for (std::size_t lane = 0; lane < kVectorWidth; ++lane) {
        std::array<double, kInputs> values;
        for (std::size_t k = 0; k < kInputs; ++k) values[k] = rows[k][lane];
        result[lane] = law_.value(values.data());
      }
      return Lanes::load(result.data());
    }
  }

  Law law_;
};

}  // namespace tactus
