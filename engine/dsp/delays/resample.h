#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// [control] The samples at another rate: output frame n lies where input frame n from / to lies, from frame
/// `first` (which may be before the first input) on, `count` of them; beyond its ends the input is 0. Each
/// is a sum over the input through a Kaiser-windowed sinc, cut off at the lower of the two Nyquist
/// frequencies: pass band flat within 0.01 dB up to 0.9 of it, images and aliases below −99 dB.
/// Source: J. O. Smith, "Digital Audio Resampling Home Page", 2002.
std::vector<double> resample(std::span<const double> input, Hertz from, Hertz to, std::int64_t first,
                             std::int64_t count);

/// [any] Modified Bessel function I0 by its power series, for Kaiser windows.
double bessel_i0(double x);

/// [any] How many input frames before and behind an output frame it is made from.
std::int64_t resampling_reach(Hertz from, Hertz to);

}  // namespace tactus
