#pragma once

// Thread: [realtime].

#include <array>
#include <cstring>
#include <type_traits>

#include "engine/core/transpose.h"
#include "engine/dsp/simd/lanes.h"
#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {

/// [realtime] Whether none of the operands moves.
inline bool all_rest(const Signal* in) noexcept {
  return in[0].constant() && in[1].constant() && in[2].constant();
}

/// [realtime] out[n] = op(in[0][n], in[1][n], in[2][n]), as in `evaluate`, for n in [0, frames).
void run_operation(Expression::Op op, const Signal* in, double* out, int frames) noexcept;

/// [realtime]
inline bool is_finite(double sample) noexcept { return tactus_is_finite(sample) != 0; }

/// 0 for each finite sample that is added, else a NaN.
class FiniteSum {
 public:
  void add(Lanes samples) noexcept { sum_ = fused_multiply_add(samples, Lanes::broadcast(0), sum_); }
  void add(double sample) noexcept { rest_ += sample * 0; }
  void add(const FiniteSum& other) noexcept { sum_ = sum_ + other.sum_; }
  bool finite() const noexcept { return sum_.all_zero() && rest_ == 0; }

 private:
  Lanes sum_ = Lanes::broadcast(0);
  double rest_ = 0;
};

bool row_is_finite(const double* samples, int frames) noexcept;

/// [realtime] False if one of the samples is a NaN or infinite. The shortest blocks of sound cards come
/// first.
[[gnu::always_inline]] inline bool all_finite(const double* samples, int frames) noexcept {
  if (frames == 2 * Lanes::kCount) {
    FiniteSum sum;
    sum.add(Lanes::load(samples));
    sum.add(Lanes::load(samples + Lanes::kCount));
    return sum.finite();
  }
  return frames == 1 ? is_finite(*samples) : row_is_finite(samples, frames);
}

/// [realtime] Copies, with denormals and -0 as 0; the thread flushes denormals. False if one of the samples
/// is a NaN or infinite.
inline bool copy_finite(const double* from, int frames, double* to) noexcept {
  constexpr int kLanes = Lanes::kCount;
  FiniteSum sum;
  for (const double* const end = from + (frames & -kLanes); from != end; from += kLanes, to += kLanes) {
    const auto samples = Lanes::load(from);
    sum.add(samples);
    (samples + Lanes::broadcast(0)).store(to);
  }
  for (int rest = frames & (kLanes - 1); rest > 0; --rest) {
    sum.add(*from);
    *to++ = *from++ + 0.0;
  }
  return sum.finite();
}

/// [realtime] The same for kVectorWidth rows that become lanes: to[n * kVectorWidth + k] = from[k][n].
inline bool pack_finite(const std::array<const double*, kVectorWidth>& from, int frames,
                        double* to) noexcept {
  Transpose::Row sum{};
  double rest = 0;
  Transpose::pack(from, to, frames, [&](auto samples) {
    if constexpr (std::is_same_v<decltype(samples), double>)
      rest += samples * 0;
    else
      sum += samples * 0.0;
    return samples + 0.0;
  });
  double sums[Transpose::kCount];
  std::memcpy(sums, &sum, sizeof sums);
  return Lanes::load(sums).all_zero() && rest == 0;
}

/// [realtime] `frames` if there is none.
int first_nonfinite(const double* samples, int frames) noexcept;

/// [realtime] Makes NaN and infinity 0. Returns how many there were.
int clear_nonfinite(double* samples, int frames) noexcept;

}  // namespace tactus
