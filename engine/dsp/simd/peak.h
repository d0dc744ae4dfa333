#pragma once

namespace tactus {

/// [realtime] The larger of `so_far` and every |sample|; a NaN does not count.
double highest_magnitude(const double* samples, int count, double so_far) noexcept;

}  // namespace tactus
