#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <utility>

#include "engine/graph/node.h"

namespace tactus {

/// A node without memory: one output, a function of the inputs of the same frame.
/// `Law` has `static constexpr int kInputs`, `double value(in) const` and `double slope(input, in) const`,
/// where `in` are the inputs' values in declaration order; `slope` is the derivative by one of them, which is
/// the response.
template <class Law>
class ElementwiseNode final : public Node {
 public:
  explicit ElementwiseNode(Law law) : law_(std::move(law)) {}

  void process(const NodeBlock& block) noexcept override {
    double* const out = block.out[0];
    Values in{};
    for (int k = 0; k < Law::kInputs; ++k) in[k] = block.in[k][0];
    if (only_first_moves(block)) {
      // The same function of the same values, where the compiler can see that they rest.
      const double* const moving = block.in[0].data;
      for (int i = 0; i < block.frames; ++i) {
        in[0] = moving[i];
        out[i] = law_.value(in.data());
      }
      return;
    }
    for (int i = 0; i < block.frames; ++i) {
      for (int k = 0; k < Law::kInputs; ++k) in[k] = block.in[k][i];
      out[i] = law_.value(in.data());
    }
  }
  void reset() noexcept override {}

  std::optional<std::complex<double>> response(int input, int, Hertz,
                                               std::span<const double> at) const override {
    return law_.slope(input, at.data());
  }

 private:
  using Values = std::array<double, static_cast<std::size_t>(Law::kInputs)>;

  static bool only_first_moves(const NodeBlock& block) {
    for (int k = 1; k < Law::kInputs; ++k)
      if (!block.in[k].constant()) return false;
    return block.in[0].stride == 1;
  }

  Law law_;
};

}  // namespace tactus
