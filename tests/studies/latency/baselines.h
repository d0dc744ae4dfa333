#pragma once

#include <span>
#include <vector>

#include "engine/core/units.h"

// Two ways that others measure a delay, to stand beside ours.
namespace tactus::study {

/// The highest place of the cross-correlation, and the top of the parabola through it and its neighbours.
double correlate_with_parabola(std::span<const double> played, std::span<const double> captured);

/// The five tones of jack_delay: F sample_rate / 65536 for F = 4096, 512, 1088, 1544, 2049, the first with an
/// amplitude of 0.2, the others of 0.1, times `level` / 0.6. Source: F. Adriaensen, jack_delay 0.4.2.
std::vector<double> five_tones(std::size_t frames, double level);
/// The delay from the phases of the tones: the first tells it modulo 16 frames, each further one adds three
/// bits, up to 65536 frames. The phases are averaged over `captured` from `settled` on, where all tones are
/// there.
double phase_delay_of_tones(std::span<const double> captured, std::size_t settled);

}  // namespace tactus::study
