#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "engine/core/median.h"
#include "engine/physics/network.h"
#include "tests/studies/networks/true_motion.h"
#include "tests/support/random_networks.h"

// How true is the error that is reported? `networks_study NETWORKS [FIRST]` steps random networks by every
// solver, measures the error of each against the reference solution, as `tactus render --error` does, and
// both against a solution of its own (`true_motion`). Prints a table, and what is wrong with which seed. Exit
// code 1: something is.

using namespace tactus;
using namespace tactus::study;
using namespace tactus::test;

namespace {

using Path = std::vector<double>;

struct Played {
  Path path;
  bool refused = false, finite = true;
  double gained = 0;  ///< relative to the energy at the start, without a signal

  bool makes_energy() const { return gained > 1e-6; }
};

/// Of masses, springs, contacts and bonds at the start, whatever a solver makes of it. [J]
double start_energy(const RandomNetwork& random) {
  const auto network = Network::make(random.elements, 1, random.rate, Solver::Reference, 1).value();
  return network.energy(network.initial_state());
}

/// The position of the watched point. Without a signal there is never more energy than at the start.
Played play(const RandomNetwork& random, Solver solver, int oversample, double start) {
  Played played;
  const auto network = Network::make(random.elements, 1, random.rate, solver, oversample);
  if (!network) return played.refused = true, played;
  auto state = network->initial_state();
  played.path.push_back(network->position(state, random.watched));
  for (int n = 0; n < random.frames; ++n) {
    const double signal = random.signal(n);
    network->step(state, &signal);
    const double energy = network->energy(state), place = network->position(state, random.watched);
    if (!random.driven) played.gained = std::max(played.gained, (energy - start) / (start + 1e-15));
    played.finite = played.finite && std::isfinite(energy) && std::isfinite(place);
    played.path.push_back(place);
  }
  return played;
}

/// The largest difference relative to the largest way from the start, as the measure "position" is compared.
double apart(const Path& path, const Path& expected) {
  double most = 0.0, way = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!std::isfinite(path[i])) return INFINITY;
    most = std::max(most, std::abs(path[i] - expected[i]));
    way = std::max(way, std::abs(expected[i]));
  }
  return way > 0.0 ? most / way : most;
}

/// What became of all networks with one solver.
struct Tally {
  int compared = 0, refused = 0, infinite = 0, gained = 0, doubtful = 0, too_small = 0;
  std::vector<double> ratios, errors;
};

class Study {
 public:
  void add(std::uint64_t seed) {
    const auto random = RandomNetworks(seed).make();
    start_ = start_energy(random);
    const auto whole = play(random, Solver::Reference, 1, start_),
               thirds = play(random, Solver::Reference, 3, start_);
    const auto truth = true_motion(random);
    ++networks_;
    const double floor = whole.finite && thirds.finite ? apart(thirds.path, whole.path) : INFINITY;
    unsolved_ += !std::isfinite(floor);
    without_truth_ += !truth;
    if (truth && std::isfinite(floor)) {
      const double wrong = apart(whole.path, *truth);
      reference_errors_.push_back(wrong);
      if (wrong > 1e-6 && wrong > 10.0 * floor)
        complain(seed, fmt::format("the reference is {:.1e} off, and says {:.1e}", wrong, floor), random);
    }
    const auto choice = choose_solver(random.elements, random.rate, 0);
    note_choice(choice);
    add(seed, random, "explicit", Solver::Explicit, 1, whole.path, floor, truth);
    add(seed, random, "passive", Solver::Passive, 1, whole.path, floor, truth);
    add(seed, random, "implicit", Solver::Implicit, 1, whole.path, floor, truth);
    add(seed, random, "exact", Solver::Exact, 1, whole.path, floor, truth);
    add(seed, random, "auto", choice.solver, choice.oversample, whole.path, floor, truth);
  }

  int print() const {
    fmt::print(
        "| solver | compared | refused | not finite | energy grows | reference in doubt | reported error too "
        "small | median ratio | median error | 90 % below |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
    for (const char* name : {"explicit", "passive", "implicit", "exact", "auto"}) {
      auto tally = tallies_.at(name);
      std::ranges::sort(tally.errors);
      const double ninety = tally.errors.empty() ? 0.0 : tally.errors[tally.errors.size() * 9 / 10];
      fmt::print("| `{}` | {} | {} | {} | {} | {} | {} | {:.3f} | {:.1e} | {:.1e} |\n", name, tally.compared,
                 tally.refused, tally.infinite, tally.gained, tally.doubtful, tally.too_small,
                 median(tally.ratios), median(tally.errors), ninety);
    }
    auto errors = reference_errors_;
    std::ranges::sort(errors);
    fmt::print(
        "\n{} networks, {} without a solution to compare with, {} that the reference cannot follow; it is "
        "off by {:.1e} "
        "(median) and {:.1e} (99 %). `auto` has a bound in {:.1f} % of them, of at most 1 % in {:.1f} %.\n",
        networks_, without_truth_, unsolved_, median(errors),
        errors.empty() ? 0.0 : errors[errors.size() * 99 / 100], 100.0 * bounded_ / networks_,
        100.0 * good_ / networks_);
    return complaints_ == 0 ? 0 : 1;
  }

 private:
  void add(std::uint64_t seed, const RandomNetwork& random, const std::string& name, Solver solver,
           int oversample, const Path& reference, double floor, const std::optional<Path>& truth) {
    auto& tally = tallies_[name];
    const auto played = play(random, solver, oversample, start_);
    if (played.refused) return void(++tally.refused);
    const bool may_explode = solver == Solver::Explicit && name == "explicit";
    tally.infinite += !played.finite;
    tally.gained += played.makes_energy();
    if (!may_explode && !played.finite) complain(seed, name + " is not finite", random);
    if (!may_explode && solver != Solver::Explicit && played.makes_energy())
      complain(seed, fmt::format("{} makes energy: {:.1e} more", name, played.gained), random);
    if (!std::isfinite(floor) || !truth || !played.finite) return;
    const double reported = apart(played.path, reference), actual = apart(played.path, *truth);
    ++tally.compared;
    tally.errors.push_back(actual);
    if (reported < 10.0 * floor) return void(++tally.doubtful);
    tally.ratios.push_back(reported / std::max(actual, 1e-12));
    // The solution to compare with is right to 1e-9 itself.
    if (actual > 1.05 * reported + 1e-8) {
      ++tally.too_small;
      complain(seed, fmt::format("{} reports {:.2e}, and is {:.2e} off", name, reported, actual), random);
    }
  }

  void note_choice(const SolverChoice& choice) {
    for (const auto& candidate : choice.candidates)
      if (candidate.solver == choice.solver && candidate.oversample == choice.oversample) {
        bounded_ += candidate.bounded;
        good_ += candidate.bounded && candidate.error <= kGoodEnough;
        return;
      }
  }

  void complain(std::uint64_t seed, const std::string& what, const RandomNetwork& random) {
    ++complaints_;
    const auto& e = random.elements;
    fmt::print(stderr,
               "seed {}: {} ({} Hz, {} frames, {} points, {} springs, {} contacts, {} frictions, {} bonds, "
               "{} coils, {} ports)\n",
               seed, what, random.rate.value, random.frames, e.points.size(), e.springs.size(),
               e.contacts.size(), e.frictions.size(), e.bonds.size(), e.coils.size(), e.ports.size());
  }

  double start_ = 0;
  std::map<std::string, Tally> tallies_;
  std::vector<double> reference_errors_;
  int networks_ = 0, without_truth_ = 0, unsolved_ = 0, bounded_ = 0, good_ = 0, complaints_ = 0;
};

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) return std::fprintf(stderr, "usage: networks_study NETWORKS [FIRST]\n"), 2;
  const auto networks = std::strtoull(arguments[1], nullptr, 10);
  const auto first = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1;
  Study study;
  for (auto seed = first; seed < first + networks; ++seed) {
    study.add(seed);
    if (seed % 10 == 0)
      std::fprintf(stderr, "\r%3.0f %%",
                   100.0 * static_cast<double>(seed - first + 1) / static_cast<double>(networks));
  }
  std::fprintf(stderr, "\r");
  return study.print();
}
