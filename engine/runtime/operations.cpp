#include "engine/runtime/operations.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tactus {
namespace {

/// One loop for each combination of samples and constants, so that each is a plain vector loop.
template <class F>
void binary(const Signal* in, double* out, int frames, F f) noexcept {
  const double* a = in[0].data;
  const double* b = in[1].data;
  if (in[0].constant()) {
    const double left = *a;
    for (int n = 0; n < frames; ++n) out[n] = f(left, b[n * in[1].stride]);
  } else if (in[1].constant()) {
    const double right = *b;
    for (int n = 0; n < frames; ++n) out[n] = f(a[n], right);
  } else {
    for (int n = 0; n < frames; ++n) out[n] = f(a[n], b[n]);
  }
}

template <class F>
void unary(const Signal* in, double* out, int frames, F f) noexcept {
  for (int n = 0; n < frames; ++n) out[n] = f(in[0].data[n * in[0].stride]);
}

template <class F>
void ternary(const Signal* in, double* out, int frames, F f) noexcept {
  const Signal a = in[0], b = in[1], c = in[2];
  for (int n = 0; n < frames; ++n)
    out[n] = f(a.data[n * a.stride], b.data[n * b.stride], c.data[n * c.stride]);
}

template <std::size_t kEntry>
void run(const Signal* in, double* out, int frames) noexcept {
  constexpr auto& type = kOperators[kEntry];
  constexpr auto value = type.value;
  if constexpr (type.operands == 1)
    unary(in, out, frames, [](double a) { return value(a, 0, 0); });
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

}  // namespace

void run_operation_row(Expression::Op op, const Signal* in, double* out, int frames) noexcept {
  if (const int operands = operator_of(op).operands; all_rest(in, operands)) {  // controls at rest
    std::fill_n(out, frames, evaluate(op, in[0][0], in[1][0], operands < 3 ? 0 : in[2][0]));
    return;
  }
  kRuns[entry_of(op)](in, out, frames);
}

bool row_is_finite(const double* samples, int frames) noexcept {
  // A step of the exponent carries into the sign's place exactly where every bit of it was set.
  std::uint64_t carried = 0;
  for (int n = 0; n < frames; ++n)
    carried |= (std::bit_cast<std::uint64_t>(samples[n]) & kExponentBits) + kExponentStep;
  return (carried >> 63) == 0;
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
