#include "engine/graph/plan/vector_nodes.h"

#include <algorithm>
#include <array>

#include "engine/core/transpose.h"
#include "engine/graph/semantics/expression.h"

namespace tactus {
namespace {

using Row = std::array<double, kVectorWidth>;

/// The lanes of one frame of an input, whatever its stride.
template <bool kSame>
double lane_of(const double* frame, int lane) noexcept {
  return frame[kSame ? 0 : lane];
}

template <Expression::Op kOp, bool kSameLeft, bool kSameRight>
void run(const Signal* in, double* out, int frames) noexcept {
  const double* left = in[0].data;
  const double* right = in[1].data;
  const auto left_stride = in[0].stride, right_stride = in[1].stride;
  for (int n = 0; n < frames; ++n, out += kVectorWidth) {
    Row result;
    for (int lane = 0; lane < kVectorWidth; ++lane)
      result[index(lane)] = apply(kOp, lane_of<kSameLeft>(left, lane), lane_of<kSameRight>(right, lane));
    std::copy_n(result.data(), kVectorWidth, out);
    left += left_stride;
    right += right_stride;
  }
}

template <Expression::Op kOp>
void run(const Signal* in, double* out, int frames) noexcept {
  const bool same_left = in[0].stride == 1, same_right = in[1].stride == 1;
  if (same_left && same_right) return run<kOp, true, true>(in, out, frames);
  if (same_left) return run<kOp, true, false>(in, out, frames);
  if (same_right) return run<kOp, false, true>(in, out, frames);
  return run<kOp, false, false>(in, out, frames);
}

}  // namespace

void VectorOperation::process(const NodeBlock& block) noexcept {
  for_operator(op_, [&](auto constant) { run<constant()>(block.in, block.out[0], block.frames); });
}

void Pack::process(const NodeBlock& block) noexcept {
  double* out = block.out[0];
  if (std::all_of(block.in, block.in + kVectorWidth, [](const Signal& lane) { return lane.stride == 1; })) {
    std::array<const double*, kVectorWidth> rows;
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane) rows[lane] = block.in[lane].data;
    return Transpose::pack(rows, out, block.frames);
  }
  for (int n = 0; n < block.frames; ++n)
    for (int lane = 0; lane < kVectorWidth; ++lane) *out++ = block.in[lane][n];
}

void LaneSum::process(const NodeBlock& block) noexcept {
  const int whole = lanes_ / kVectorWidth, rest = lanes_ % kVectorWidth, all = block.frames * kVectorWidth;
  // Adding -0 changes no number, not even its sign.
  if (whole == 0) std::fill_n(sums_.begin(), all, -0.0);
  if (whole > 0) std::copy_n(block.in[0].data, all, sums_.begin());
  for (int i = 1; i < whole; ++i) {
    const double* const rows = block.in[i].data;
    for (int k = 0; k < all; ++k) sums_[index(k)] += rows[k];
  }
  double* sum = sums_.data();
  for (int n = 0; n < block.frames; ++n, sum += kVectorWidth) {
    for (int lane = 0; lane < rest; ++lane) sum[lane] += block.in[whole].data[n * kVectorWidth + lane];
    const auto half = [sum](int lane) { return sum[lane] + sum[lane + kVectorWidth / 2]; };
    block.out[0][n] = (half(0) + half(2)) + (half(1) + half(3));
  }
}

}  // namespace tactus
