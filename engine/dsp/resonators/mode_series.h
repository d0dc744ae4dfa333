#pragma once

#include <vector>

namespace tactus {

/// Families of modes, as ratios of their frequencies to the first one's:
///
///   Harmonic    k                                            strings, pipes
///   Geometric   span^((k - 1) / (modes - 1))                 even steps of pitch
///   Bar         (b_k / b_1)^2,  cos b cosh b = 1             free at both ends: marimba, glockenspiel
///   ClampedBar  (b_k / b_1)^2,  cos b cosh b = -1            held at one end: kalimba, music box
///   Membrane    zeros of the Bessel functions J_m, m >= 0    drum, each pair of equal modes once
///
/// Source: Fletcher & Rossing, The Physics of Musical Instruments, 2nd ed. 1998, chapters 2 and 3.
enum class ModeSeries { Harmonic, Geometric, Bar, ClampedBar, Membrane };

/// [control] The first `modes` (at least 1) of them, rising. `span` >= 1 is the last of a geometric series.
std::vector<double> mode_ratios(ModeSeries series, int modes, double span);

}  // namespace tactus
