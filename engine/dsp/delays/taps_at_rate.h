#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

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
