#include "tests/support/slip_events.h"

#include <algorithm>
#include <utility>

namespace tactus::test {
namespace {

constexpr int kParts = 8;  // the reference takes so many steps a frame

/// The end of the first part of a frame in which a friction begins to slide, to hold or to turn round, or a
/// plectrum slips, or of the last one. [frames]
double first_event(Slipping slipping, Solver solver, double scale, int parts) {
  for (auto& friction : slipping.elements.frictions) {
    friction.law.kinetic *= scale, friction.viscous *= scale;
    for (auto& drop : friction.law.drops) drop.size *= scale;
  }
  for (auto& bond : slipping.elements.bonds) bond.limit *= scale;
  const Hertz rate{slipping.rate.value * parts};
  const auto network = Network::make(slipping.elements, 1, rate, solver, 1).value();
  auto state = network.initial_state();
  const auto start = std::pair{state.sliding, state.slipped};
  for (int n = 0; n < slipping.frames * parts; ++n) {
    const double signal = slipping.signal(n / parts);
    network.step(state, &signal);
    if (std::pair{state.sliding, state.slipped} != start) return static_cast<double>(n + 1) / parts;
  }
  return slipping.frames;
}

}  // namespace

double first_event_error(const Slipping& slipping, Solver solver, int oversample, double error) {
  double first = slipping.frames, last = 0.0;
  for (const double scale : {1.0 - error, 1.0, 1.0 + error}) {
    const double end = first_event(slipping, Solver::Reference, scale, kParts);
    first = std::min(first, end - 1.0 / kParts), last = std::max(last, end);
  }
  // Each step by itself: what begins and ends within a frame is seen, too.
  const double end = first_event(slipping, solver, 1.0, oversample);
  return std::max({0.0, end - 1.0 / oversample - last, first - end});
}

}  // namespace tactus::test
