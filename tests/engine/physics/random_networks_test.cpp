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
// Of networks that once started with too much: of three frictions on one mass, of bonds that share masses,
// of bodies that part from a stiff contact.
constexpr std::uint64_t kAtStart[] = {248, 407, 987};

void check_steps(const RandomNetwork& random, std::uint64_t seed, Solver solver) {
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
  const auto check = [&](std::uint64_t seed) { check_steps(RandomNetworks(seed).make(), seed, solver); };
  for (auto seed = kFirst; seed <= kLast; ++seed) check(seed);
  for (const auto seed : kAtRest) check(seed);
  for (const auto seed : kAtStart) check(seed);
}

TEST_CASE("random networks: contacts that are pressed at the start give no more than they hold",
          "[physics]") {
  // Pressed by up to 1.5 mm, among them 158 and 454, whose bodies part fast, and 232, which have losses.
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  const auto check = [&](std::uint64_t seed) {
    auto random = RandomNetworks(seed).make();
    random.driven = false;
    for (auto& contact : random.elements.contacts) contact.offset += 1.5e-3;
    if (!random.elements.contacts.empty()) check_steps(random, seed, solver);
  };
  for (auto seed = kFirst; seed <= kLast; ++seed) check(seed);
  for (const std::uint64_t seed : {109, 158, 165, 232, 243, 454}) check(seed);
}
