#pragma once

#include <optional>
#include <vector>

#include "tests/support/random_networks.h"

namespace tactus::study {

/// Has it a friction or a plectrum?
bool may_slip(const NetworkElements& elements);

/// Positions of the watched point at frames 0 ... `frames`, by equations of motion written again and in
/// numbers of more digits where the machine has them; nothing is shared with the engine.
///  - linear: the exponential of the matrix of the whole system, by Pade approximation (Eigen), in `long
///  double`;
///  - contacts: Dormand & Prince's method of order 5 with errors of 1e-12 (J. Comput. Appl. Math. 6, 1980).
/// None: what may slip, which has no such solution, or more than a million steps.
std::optional<std::vector<double>> true_motion(const test::RandomNetwork& network);

}  // namespace tactus::study
