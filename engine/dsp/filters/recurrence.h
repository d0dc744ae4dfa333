#pragma once

// Thread: [realtime].

#include <algorithm>
#include <array>
#include <cstdint>

#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// Recurrences step in groups of this many frames, which lie on the absolute frame grid.
inline constexpr int kGroup = Lanes::kCount;

/// Place of a frame in its group. Coefficients may change where this is 0.
inline int group_position(std::int64_t frame) noexcept { return static_cast<int>(frame & (kGroup - 1)); }

/// A linear recurrence of order 1 or 2, vectorised in time:
///
///   y[n] = v[n] + a1 y[n-1] (+ a2 y[n-2])
///
/// The eight outputs of a group are the response to the last outputs before it plus a triangular sum over its
/// inputs, h being the impulse response:
///
///   y[k] = free1[k] y[-1] (+ free2[k] y[-2]) + sum over j <= k of h[k-j] v[j]
///
/// so that the chain from group to group is one multiply-add an order instead of eight. A group that is cut
/// by the end of a block stores its sums and continues later with the same operations in the same order: the
/// output is bit for bit the same for any cutting into blocks (the sums of frames to come add ±0; hence the +
/// 0 at the end). Error against exact arithmetic: that of the plain recurrence, a rounding a frame at most.
/// `design` belongs at the start of a group; anywhere else the rest of the group mixes two recurrences.
template <int Order>
class Recurrence {
  static_assert(Order == 1 || Order == 2);

 public:
  Recurrence() noexcept {
    constexpr double kNone[Order] = {};
    design(kNone);
  }

  /// [realtime] By a1 (and a2). About 25 multiplications.
  void design(const double* a) noexcept {
    std::array<double, kGroup + 1> h{1.0, a[0]};
    for (std::size_t k = 2; k <= kGroup; ++k) {
      h[k] = a[0] * h[k - 1];
      if constexpr (Order == 2) h[k] = fused_multiply_add(a[1], h[k - 2], h[k]);
    }
    for (std::size_t j = 0; j < kGroup; ++j)
      for (std::size_t k = j; k < kGroup; ++k) columns_[j][k] = h[k - j];
    for (std::size_t k = 0; k < kGroup; ++k) {
      free_[0][k] = h[k + 1];
      if constexpr (Order == 2) free_[1][k] = a[1] * h[k];
    }
  }

  void reset() noexcept {
    last_.fill(0.0);
    sums_.fill(0.0);  // the first group may start in its middle
  }

  /// [realtime] `position` is the group_position of the first frame. `v` and `y` may be the same.
  void run(const double* v, double* y, int frames, int position) noexcept {
    if (position != 0) {
      const int rest = std::min(frames, kGroup - position);
      part(v, y, rest, position);
      v += rest, y += rest, frames -= rest;
    }
    const int groups = frames / kGroup;
    if (groups > 0) run_groups(y, groups, [v](int g) { return v + g * kGroup; });
    if (const int left = frames % kGroup; left > 0) part(v + groups * kGroup, y + groups * kGroup, left, 0);
  }

  /// [realtime] `run` for whole groups from the start of one. `input(g)` is asked for the eight inputs of
  /// group g, in order.
  template <class Input>
  void run_groups(double* y, int groups, Input input) noexcept {
    auto last = remembered();
    auto outputs = Lanes::broadcast(0.0);
    for (int g = 0; g < groups; ++g, y += kGroup) {
      const double* const v = input(g);
      auto sums = Lanes::broadcast(0.0);
      for (int j = 0; j < kGroup; ++j) sums = fused_multiply_add(column(j), Lanes::broadcast(v[j]), sums);
      outputs = with_free_response(sums, last);
      last = last_of(outputs);
      (outputs + Lanes::broadcast(0.0)).store(y);
    }
    remember(outputs);
  }

  /// [realtime] Continues from the state of `other`, at the start of a group.
  void adopt(const Recurrence& other) noexcept {
    last_ = other.last_;
    sums_ = other.sums_;
  }

  /// [realtime] `run` for one frame: the output does not depend on all lanes.
  double run_single(double v, int position) noexcept {
    const auto k = static_cast<std::size_t>(position);
    double y = position == 0 ? 0.0 : sums_[k];
    fused_multiply_add(column(position), Lanes::broadcast(v), sums_before(position)).store(sums_.data());
    y = fused_multiply_add(columns_[k][k], v, y);
    if constexpr (Order == 2) y = fused_multiply_add(free_[1][k], last_[1], y);
    y = fused_multiply_add(free_[0][k], last_[0], y);
    if (position == kGroup - 1) remember(with_free_response(Lanes::load(sums_.data()), remembered()));
    return y + 0.0;
  }

 private:
  using Group = std::array<double, kGroup>;
  using LastOutputs = std::array<Lanes, Order>;  ///< y[-1], y[-2], each in every lane

  Lanes column(int j) const noexcept { return Lanes::load(columns_[static_cast<std::size_t>(j)].data()); }

  Lanes with_free_response(Lanes sums, const LastOutputs& last) const noexcept {
    if constexpr (Order == 2) sums = fused_multiply_add(Lanes::load(free_[1].data()), last[1], sums);
    return fused_multiply_add(Lanes::load(free_[0].data()), last[0], sums);
  }

  static LastOutputs last_of(Lanes outputs) noexcept {
    if constexpr (Order == 2)
      return {outputs.template spread<7>(), outputs.template spread<6>()};
    else
      return {outputs.template spread<7>()};
  }

  LastOutputs remembered() const noexcept {
    LastOutputs last;
    for (std::size_t i = 0; i < Order; ++i) last[i] = Lanes::broadcast(last_[i]);
    return last;
  }

  void remember(Lanes outputs) noexcept {
    Group y;
    outputs.store(y.data());
    for (std::size_t i = 0; i < Order; ++i) last_[i] = y[kGroup - 1 - i];
  }

  Lanes sums_before(int position) const noexcept {
    return position == 0 ? Lanes::broadcast(0.0) : Lanes::load(sums_.data());
  }

  void part(const double* v, double* y, int frames, int position) noexcept {
    auto sums = sums_before(position);
    for (int j = 0; j < frames; ++j)
      sums = fused_multiply_add(column(position + j), Lanes::broadcast(v[j]), sums);
    sums.store(sums_.data());
    const auto outputs = with_free_response(sums, remembered());
    Group ready;
    (outputs + Lanes::broadcast(0.0)).store(ready.data());
    for (int n = 0; n < frames; ++n) y[n] = ready[static_cast<std::size_t>(position + n)];
    if (position + frames == kGroup) remember(outputs);
  }

  alignas(64) std::array<Group, kGroup> columns_{};  ///< [j][k] = h[k - j], 0 above the diagonal
  alignas(64) std::array<Group, Order> free_{};
  alignas(64) Group sums_{};
  std::array<double, Order> last_{};  ///< outputs before this group, newest first
};

}  // namespace tactus
