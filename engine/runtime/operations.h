#pragma once

#include "engine/graph/flat_graph.h"
#include "engine/graph/node.h"

namespace tactus {

/// [realtime] out[n] = op(in[0][n], in[1][n]), as `apply` in engine/graph/operators.h says, for n in [0,
/// frames).
void run_operation(Term::Op op, const Signal* in, double* out, int frames) noexcept;

/// [realtime] False if one of the samples is a NaN or infinite.
bool all_finite(const double* samples, int frames) noexcept;

/// [realtime] Makes NaN and infinity 0. Returns how many there were.
int clear_nonfinite(double* samples, int frames) noexcept;

}  // namespace tactus
