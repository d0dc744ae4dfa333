#pragma once

// Thread: [realtime].

#include <algorithm>
#include <array>
#include <complex>

#include "engine/dsp/filters/filter_kernel.h"
#include "engine/dsp/filters/recurrence.h"

namespace tactus {

/// [any] H of a design, where `delay` is z^-1.
inline std::complex<double> filter_response(const tactus_filter_design& design, std::complex<double> delay) {
  std::complex<double> above = design.b[design.order], below = 0;
  for (int i = design.order; i-- > 0;) {
    above = above * delay + design.b[i];
    below = (below + design.a[i]) * delay;
  }
  return above / (1.0 - below);
}

/// A filter of order 1 or 2 in direct form I, vectorised in time. The state is the last inputs and outputs,
/// so that a change of coefficients never jumps.
template <int Order>
class LinearFilter {
 public:
  /// [realtime] At the start of a group only (see Recurrence).
  void design(const tactus_filter_design& c, int /*lane*/ = 0) noexcept {
    std::copy_n(c.b, Order + 1, b_.begin());
    recurrence_.design(c.a);
  }
  void reset() noexcept {
    last_.fill(0.0);
    recurrence_.reset();
  }
  /// [realtime] At least one frame. `position` is the group_position of the first; `x` and `y` do not
  /// overlap.
  void run(const double* x, double* y, int frames, int position) noexcept {
    if (position == 0 && frames % kGroup == 0) return run_groups(x, y, frames / kGroup);
    feed_forward(x, y, frames);
    recurrence_.run(y, y, frames, position);
  }
  /// [realtime] `run` for one frame.
  double run_single(double x, int position) noexcept {
    const double v = weighted(x, last_[0], last_[Order - 1], {b_[0], b_[1], Order == 2 ? b_[Order] : 0.0});
    if constexpr (Order == 2) last_[1] = last_[0];
    last_[0] = x;
    return recurrence_.run_single(v, position);
  }

 private:
  /// Rounded product by product, not fused: equal inputs under b = (1, -1) or (1, -2, 1) then cancel exactly,
  /// which a high-pass with a low cutoff would otherwise amplify a million times.
  template <class Number>
  static Number weighted(Number now, Number before, Number oldest, const std::array<Number, 3>& b) noexcept {
    if constexpr (Order == 2)
      return (b[0] * now + b[2] * oldest) + b[1] * before;
    else
      return b[0] * now + b[1] * before;
  }

  /// The inputs of whole groups are shifted in registers: a vector that lies across two that were just stored
  /// waits for both.
  class Shifted {
   public:
    explicit Shifted(const LinearFilter& filter) noexcept
        : b_{Lanes::broadcast(filter.b_[0]), Lanes::broadcast(filter.b_[1]),
             Lanes::broadcast(filter.b_[Order])},
          last_(Lanes::broadcast(filter.last_[0])),
          last_before_(Lanes::broadcast(filter.last_[Order - 1])) {}
    /// The feed-forward part of the next group.
    Lanes next(const double* x) noexcept {
      const auto now = Lanes::load(x), one_before = now.moved_up(last_);
      const auto two_before = one_before.moved_up(last_before_);
      last_ = now;
      last_before_ = one_before;
      return weighted(now, one_before, two_before, b_);
    }

   private:
    std::array<Lanes, 3> b_;
    Lanes last_, last_before_;
  };

  void run_groups(const double* x, double* y, int groups) noexcept {
    Shifted shifted(*this);
    recurrence_.run_groups(y, groups, [&](int g) {
      double* const v = y + g * kGroup;
      shifted.next(x + g * kGroup).store(v);
      return v;
    });
    for (int i = 0; i < Order; ++i) last_[static_cast<std::size_t>(i)] = x[groups * kGroup - 1 - i];
  }

  void feed_forward(const double* x, double* v, int frames) noexcept {
    const std::array<double, 3> b{b_[0], b_[1], Order == 2 ? b_[Order] : 0.0};
    double before = last_[0], oldest = last_[Order - 1];
    int i = 0;
    if (frames >= Lanes::kCount) {
      Shifted shifted(*this);
      for (; i + Lanes::kCount <= frames; i += Lanes::kCount) shifted.next(x + i).store(v + i);
      before = x[i - 1];
      oldest = x[i - Order];
    }
    for (; i < frames; ++i) {
      v[i] = weighted(x[i], before, oldest, b);
      oldest = Order == 2 ? before : x[i];
      before = x[i];
    }
    last_[Order - 1] = oldest;
    last_[0] = before;
  }

  std::array<double, Order + 1> b_{1.0};
  std::array<double, Order> last_{};  ///< inputs, newest first
  Recurrence<Order> recurrence_;
};

/// Eight filters of order 1 or 2, each with its own coefficients, in direct form I like
/// LinearFilter. The recurrence runs frame by frame in all lanes at once: one multiply-add a frame on the
/// chain, for eight voices. The output is the same for any cutting into blocks; against LinearFilter it
/// differs by rounding.
template <int Order>
class VectorFilter {
 public:
  /// [realtime] From the next frame on.
  void design(const tactus_filter_design& c, int lane) noexcept {
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
