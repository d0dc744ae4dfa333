#include "engine/runtime/operations.h"

#include <algorithm>
#include <cmath>

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

template <Expression::Op kOp>
void run(const Signal* in, double* out, int frames) noexcept {
  if constexpr (kOp == Expression::Op::Negate || kOp == Expression::Op::Abs || kOp == Expression::Op::Signal)
    unary(in, out, frames, [](double a) { return apply(kOp, a, 0.0); });
  else
    binary(in, out, frames, [](double a, double b) { return apply(kOp, a, b); });
}

}  // namespace

void run_operation_row(Expression::Op op, const Signal* in, double* out, int frames) noexcept {
  if (in[0].constant() && in[1].constant()) {  // controls at rest
    std::fill_n(out, frames, apply(op, in[0][0], in[1][0]));
    return;
  }
  for_operator(op, [&](auto constant) { run<constant()>(in, out, frames); });
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
