#include "tests/support/random_networks.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/physics/network.h"

using namespace tactus;
using namespace tactus::test;

namespace {

// Seeds of networks whose contacts once returned their energy to a mass at rest all at once, which rounding
// turned into infinite forces.
constexpr std::uint64_t kFirst = 1, kLast = 40, kAtRest[] = {213, 265, 845};

void check_steps(std::uint64_t seed, Solver solver) {
  const auto random = RandomNetworks(seed).make();
  const auto network = Network::make(random.elements, 1, random.rate, solver, 1);
  REQUIRE(network);
  auto state = network->initial_state();
  const auto motion = Network::make(random.elements, 1, random.rate, Solver::Reference, 1).value();
  const double at_start = motion.energy(motion.initial_state());  // whatever the solver makes of it
  double most = 0.0;
  bool finite = true;
  for (int n = 0; n < random.frames; ++n) {
    const double signal = random.signal(n);
    network->step(state, &signal);
    const double energy = network->energy(state);
    most = std::max(most, energy);
    finite = finite && std::isfinite(energy) && std::isfinite(network->position(state, random.watched));
  }
  CAPTURE(seed, static_cast<int>(solver), at_start, most);
  CHECK(finite);
  if (!random.driven) CHECK(most <= at_start * (1.0 + 1e-6) + 1e-15);
}

}  // namespace

TEST_CASE("random networks: without a signal no solver but the explicit one makes energy", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  for (auto seed = kFirst; seed <= kLast; ++seed) check_steps(seed, solver);
  for (const auto seed : kAtRest) check_steps(seed, solver);
}
