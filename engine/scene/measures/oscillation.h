#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// [control] Quantities of a sampled motion, interpolated between the samples.

/// From the first to the last swing, by its rises and its fall through the middle between the highest and the
/// lowest sample, each on the polynomial through eight samples. Its own error is below (w T)^9 / 1000 of a
/// radian in all swings. Nothing: fewer than two rises.
std::optional<double> frequency_of(std::span<const double> samples, Hertz rate);

/// a of a motion A e^-at about 0: the slope of the logarithm of its peaks, each on a parabola through three
/// samples. [1/s] Nothing: fewer than two peaks.
std::optional<double> decay_of(std::span<const double> samples, Hertz rate);

/// Of the straight line nearest to the samples. [unit/s] Nothing: fewer than two.
std::optional<double> slope_of(std::span<const double> samples, Hertz rate);

/// When the samples fall from above 0 to 0 or below, on the parabola through the three samples before: what
/// happens after a touch cannot move it. [s] from the first sample
std::vector<double> falls_through_zero(std::span<const double> samples, Hertz rate);

}  // namespace tactus
