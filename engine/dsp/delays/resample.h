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

/// [control] An impulse response with a tap each sample at the rate `from`, as taps at the rate `to`: up to
/// 0.9 of the lower Nyquist frequency the same response, above it nothing. (Samples are those of a density,
/// so they shrink as the rate grows.)
///
/// Band-limited, a response that begins at once begins a little before its time. What would lie there moves
/// behind frame 0, to where the response changes least below half of the lower Nyquist frequency: by less
/// than 0.1 dB and 1 degree even for a single tap at frame 0. The same rate keeps the taps as they are.
std::vector<double> taps_at_rate(std::span<const double> taps, Hertz from, Hertz to);

/// [any] At most so many become of `taps`.
std::size_t length_at_rate(std::size_t taps, Hertz from, Hertz to);

}  // namespace tactus
