#pragma once

#include "engine/study/walls/virtual_wall.h"

namespace tactus {

/// Between walls that a loop renders and walls that explode.
struct WallBorder {
  double stiffness = 0;  ///< [N/m]; 0: no wall at all is stable
  Hertz frequency = {};  ///< at which the device then swings for ever
};

/// [control] The stiffest stable wall, exactly: device and hold in the z-domain,
///     G(z) = z^-d ((z - p) (h1 z^-1 + h2) + c (g1 z^-1 + g2)) / ((z - 1) (z - p)),   p = e^(-b T / m),
/// where the force of d frames ago acts for the last (1 - f) T of a frame and the one before it for the first
/// f T (d + f = tau_d / T; h, g, c: held_mass.h). At the border a root of 1 + (K + B (1 - z^-1) / T) G = 0
/// lies on the unit circle, so K is the smallest positive number on the curve
///     -1 / G(e^jt) - B (1 - e^-jt) / T,   0 < t <= pi,
/// where it is real; all its sign changes are found on a grid of 8 points for each turn of the delay. A
/// virtual damping that is unstable by itself gives 0. Linear: no friction, no steps, no limit. Time in
/// proportion to the frames of delay.
/// Source of the method: Gryazina, Polyak, Tremba, "D-decomposition technique", Automation and Remote Control
/// 69, 2008.
WallBorder wall_border(const WallDevice& device, const WallLoop& loop);

/// [control] Largest |root| of the same loop with the stiffness K, by the eigenvalues of the companion
/// matrix: below 1 it is stable. Time in proportion to the cube of the frames of delay; at most 1000 of them.
double largest_root(const WallDevice& device, const WallLoop& loop, double stiffness);

}  // namespace tactus
