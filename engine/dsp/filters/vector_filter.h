#pragma once

// Thread: [realtime].

#include <array>

#include "engine/dsp/filters/linear_filter.h"

namespace tactus {

/// Eight filters of order 1 or 2, each with its own coefficients, in direct form I like
/// LinearFilter. The recurrence runs frame by frame in all lanes at once: one multiply-add a frame on the
/// chain, for eight voices. The output is the same for any cutting into blocks; against LinearFilter it
/// differs by rounding.
template <int Order>
class VectorFilter {
 public:
  /// [realtime] From the next frame on.
  void design(const FilterCoefficients<Order>& c, int lane) noexcept {
    for (std::size_t i = 0; i <= Order; ++i) b_[i][static_cast<std::size_t>(lane)] = c.b[i];
    for (std::size_t i = 0; i < Order; ++i) a_[i][static_cast<std::size_t>(lane)] = c.a[i];
  }

  void reset() noexcept { x_ = y_ = {}; }

  /// [realtime] `x` gives the Lanes of a frame, `y` is interleaved.
  template <class Input>
  void run(const Input& x, double* y, int frames, int /*position*/) noexcept {
    const auto b = loaded(b_);
    const auto a = loaded(a_);
    auto xs = loaded(x_), ys = loaded(y_);
    for (int n = 0; n < frames; ++n, y += Lanes::kCount) {
      const auto now = x[n];
      // Rounded product by product, so that equal inputs cancel exactly (see LinearFilter).
      auto out = b[0] * now;
      if constexpr (Order == 2) {
        out = fused_multiply_add(a[1], ys[1], (out + b[2] * xs[1]) + b[1] * xs[0]);
        xs[1] = xs[0];
        ys[1] = ys[0];
      } else {
        out = out + b[1] * xs[0];
      }
      xs[0] = now;
      ys[0] = fused_multiply_add(a[0], ys[0], out);
      ys[0].store(y);
    }
    for (std::size_t i = 0; i < Order; ++i) {
      xs[i].store(x_[i].data());
      ys[i].store(y_[i].data());
    }
  }

 private:
  using Row = std::array<double, Lanes::kCount>;

  template <std::size_t Count>
  static std::array<Lanes, Count> loaded(const std::array<Row, Count>& rows) noexcept {
    std::array<Lanes, Count> lanes;
    for (std::size_t i = 0; i < Count; ++i) lanes[i] = Lanes::load(rows[i].data());
    return lanes;
  }

  alignas(64) std::array<Row, Order + 1> b_{};
  alignas(64) std::array<Row, Order> a_{};
  alignas(64) std::array<Row, Order> x_{};  ///< last inputs, newest first
  alignas(64) std::array<Row, Order> y_{};  ///< last outputs, newest first
};

}  // namespace tactus
