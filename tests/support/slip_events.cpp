#include "tests/support/friction_events.h"

#include <algorithm>

namespace tactus::test {
namespace {

constexpr int kParts = 8;  // of a frame in which the reference is looked at

/// The end of the first part of a frame in which a friction begins to slide, to hold or to turn round, or of
/// the last one. [frames]
double first_event(Rubbed rubbed, Solver solver, int oversample, double scale, int parts) {
  for (auto& friction : rubbed.elements.frictions) {
    friction.law.kinetic *= scale, friction.viscous *= scale;
    for (auto& drop : friction.law.drops) drop.size *= scale;
  }
  const Hertz rate{rubbed.rate.value * parts};
  const auto network = Network::make(rubbed.elements, 1, rate, solver, oversample).value();
  auto state = network.initial_state();
  const auto start = state.sliding;
  for (int n = 0; n < rubbed.frames * parts; ++n) {
    const double signal = rubbed.signal(n / parts);
    network.step(state, &signal);
    if (state.sliding != start) return static_cast<double>(n + 1) / parts;
  }
  return rubbed.frames;
}

}  // namespace

double first_event_error(const Rubbed& rubbed, Solver solver, int oversample, double error) {
  double first = rubbed.frames, last = 0.0;
  for (const double scale : {1.0 - error, 1.0, 1.0 + error}) {
    const double end = first_event(rubbed, Solver::Reference, 1, scale, kParts);
    first = std::min(first, end - 1.0 / kParts), last = std::max(last, end);
  }
  const double end = first_event(rubbed, solver, oversample, 1.0, 1);
  return std::max({0.0, end - 1.0 - last, first - end});
}

}  // namespace tactus::test
