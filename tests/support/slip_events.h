#pragma once

#include <functional>

#include "engine/core/units.h"
#include "engine/physics/network.h"

namespace tactus::test {

/// Something with frictions or plectra, signal 0 at each frame, and how many frames of it.
struct Slipping {
  NetworkElements elements;
  Hertz rate{48000};
  int frames = 0;
  std::function<double(int frame)> signal;
};

/// By how many frames the first stop or slip is outside of where the reference solution has it with forces of
/// frictions and plectra that are larger or smaller by a share of at most `error`.
double first_event_error(const Slipping& slipping, Solver solver, int oversample, double error);

}  // namespace tactus::test
