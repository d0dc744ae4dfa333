#include "engine/runtime/operations.h"

#include <algorithm>
#include <array>
#include <utility>

#include "engine/core/every_block.h"
#include "engine/graph/semantics/lane_operators.h"

namespace tactus {
namespace {

/// One loop for each combination of samples and constants, so that each is a plain vector loop.
template <class F>
void binary(const Signal* in, double* out, int frames, F f) noexcept {
  const Signal left = in[0], right = in[1];
  if (left.constant())
    for (int n = 0; n < frames; ++n) out[n] = f(*left.data, right[n]);
  else if (right.constant())
    for (int n = 0; n < frames; ++n) out[n] = f(left[n], *right.data);
  else
    for (int n = 0; n < frames; ++n) out[n] = f(left[n], right[n]);
}

/// For operands of lanes, and frames that fill no vector.
template <Expression::Op kOp>
[[gnu::noinline]] void uneven(const Signal* in, double* out, int frames) noexcept {
  constexpr auto value = operator_of(kOp).value;
  binary(in, out, frames, [](double a, double b) { return value(a, b, 0); });
}

/// The same for what a vector unit can do.
template <Expression::Op kOp>
void vectorised(const Signal* in, double* out, int frames) noexcept {
  const auto left = in[0].stride, right = in[1].stride;
  if ((frames & (kVectorWidth - 1)) != 0 || left > 1 || right > 1) [[unlikely]]
    return uneven<kOp>(in, out, frames);
  const double *a = in[0].data, *b = in[1].data;
  for (double* const end = out + frames; out != end; out += kVectorWidth) {
    lanes_of<kOp>(operand_lanes(a, left == 0), operand_lanes(b, right == 0)).store(out);
    a += left * kVectorWidth, b += right * kVectorWidth;
  }
}

template <class F>
void unary(const Signal* in, double* out, int frames, F f) noexcept {
  const Signal a = in[0];
  for (int n = 0; n < frames; ++n) out[n] = f(a[n]);
}

template <class F>
void ternary(const Signal* in, double* out, int frames, F f) noexcept {
  const Signal a = in[0], b = in[1], c = in[2];
  for (int n = 0; n < frames; ++n) out[n] = f(a[n], b[n], c[n]);
}

template <std::size_t kEntry>
TACTUS_EVERY_BLOCK void run(const Signal* in, double* out, int frames) noexcept {
  constexpr auto& type = kOperators[kEntry];
  constexpr auto value = type.value;
  if constexpr (type.operands == 1)
    unary(in, out, frames, [](double a) { return value(a, 0, 0); });
  else if constexpr (kHasLanes<type.op>)
    vectorised<type.op>(in, out, frames);
  else if constexpr (type.operands == 2)
    binary(in, out, frames, [](double a, double b) { return value(a, b, 0); });
  else if constexpr (value != nullptr)
    ternary(in, out, frames, value);
}

using Run = void (*)(const Signal* in, double* out, int frames) noexcept;
constexpr auto kRuns = []<std::size_t... kEntries>(std::index_sequence<kEntries...>) {
  return std::array<Run, sizeof...(kEntries)>{run<kEntries>...};
}
(std::make_index_sequence<kOperators.size()>{});

/// Of controls at rest.
[[gnu::noinline]] void run_resting(Expression::Op op, const Signal* in, double* out, int frames) noexcept {
  std::fill_n(out, frames, evaluate(op, in[0][0], in[1][0], in[2][0]));
}

}  // namespace

TACTUS_EVERY_BLOCK void run_operation(Expression::Op op, const Signal* in, double* out, int frames) noexcept {
  if (all_rest(in))
    run_resting(op, in, out, frames);
  else
    kRuns[entry_of(op)](in, out, frames);
}

TACTUS_EVERY_BLOCK bool row_is_finite(const double* samples, int frames) noexcept {
  constexpr int kLanes = Lanes::kCount;
  FiniteSum sum;
  const double* const end = samples + (frames & -kLanes);
  if (frames >= 4 * kLanes) {  // four sums wait a quarter as long for each other
    FiniteSum second, third, fourth;
    for (; end - samples >= 4 * kLanes; samples += 4 * kLanes) {
      sum.add(Lanes::load(samples));
      second.add(Lanes::load(samples + kLanes));
      third.add(Lanes::load(samples + 2 * kLanes));
      fourth.add(Lanes::load(samples + 3 * kLanes));
    }
    second.add(third);
    sum.add(fourth);
    sum.add(second);
  }
  for (; samples != end; samples += kLanes) sum.add(Lanes::load(samples));
  for (int rest = frames & (kLanes - 1); rest > 0; --rest) sum.add(*samples++);
  return sum.finite();
}

int first_nonfinite(const double* samples, int frames) noexcept {
  return static_cast<int>(std::find_if_not(samples, samples + frames, is_finite) - samples);
}

int clear_nonfinite(double* samples, int frames) noexcept {
  const auto finite = std::count_if(samples, samples + frames, is_finite);
  std::replace_if(
      samples, samples + frames, [](double sample) { return !is_finite(sample); }, 0.0);
  return frames - static_cast<int>(finite);
}

}  // namespace tactus
