#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>

#include "engine/core/median.h"
#include "engine/physics/network.h"
#include "engine/physics/parts.h"
#include "tests/studies/networks/true_motion.h"
#include "tests/support/random_networks.h"
#include "tests/support/slip_events.h"

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

/// Without what cannot move the watched point, as a network is made of a file.
RandomNetwork needed(RandomNetwork random) {
  auto read = marks(random.elements, false);
  read[PartKind::Point][index(random.watched)] = true;
  const auto kept = needed_parts(random.elements, read, acting_parts(random.elements, {std::nullopt}));
  random.watched = keep_parts(random.elements, kept)[PartKind::Point][index(random.watched)];
  return random;
}

/// All solvers at all steps a frame, by multiplications; those that can be made.
std::vector<SolverBounds> all_candidates(const RandomNetwork& random) {
  std::vector<SolverBounds> all;
  for (int steps = 1; steps <= kMostOversample; steps *= 2)
    for (const auto& candidate : choose_solver(random.elements, random.rate, steps).candidates)
      if (candidate.limit != SolverBounds::Limit::CannotBeMade) all.push_back(candidate);
  std::ranges::stable_sort(all, {}, &SolverBounds::multiplications);
  return all;
}

/// What a network is compared with.
struct Expected {
  Path reference;
  double reference_error;     ///< what its two runs differ by
  std::optional<Path> truth;  ///< that shares nothing with the engine

  bool solved() const { return std::isfinite(reference_error); }
  /// The best that there is.
  const Path& path() const { return truth ? *truth : reference; }
  /// Whether an error of 1 % can be told from a smaller one.
  bool clear() const { return solved() && (truth || reference_error < 0.1 * kGoodEnough); }
};

/// What became of all networks with one solver.
struct Tally {
  int compared = 0, refused = 0, infinite = 0, gained = 0, doubtful = 0, too_small = 0;
  double most_gained = 0;  ///< [Played::gained]
  std::vector<double> ratios, errors;

  std::string gains() const {
    if (gained == 0) return "0";
    return most_gained > 100 ? fmt::format("{}, without end", gained)
                             : fmt::format("{}, by {:.2g} % at most", gained, 100 * most_gained);
  }
};

/// What became of the choices of `auto`.
struct Choices {
  int networks = 0, bounded = 0, good = 0, compared = 0, worse = 0;
  std::vector<double> costs;  ///< of good ones, over that of the cheapest that is right within 1 %
  std::vector<double> over_passive;
  int events = 0, early_or_late = 0;  ///< first stops and slips; those outside their bound
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

class Study {
 public:
  void add(std::uint64_t seed) {
    const auto random = RandomNetworks(seed).make();
    const double start = start_energy(random);
    const auto whole = play(random, Solver::Reference, 1, start),
               thirds = play(random, Solver::Reference, 3, start);
    ++networks_;
    const Expected expected{whole.path,
                            whole.finite && thirds.finite ? apart(thirds.path, whole.path)
                                                          : std::numeric_limits<double>::infinity(),
                            true_motion(random)};
    unsolved_ += !expected.solved();
    without_truth_ += !expected.truth;
    if (expected.truth && expected.solved()) {
      const double wrong = apart(whole.path, *expected.truth), says = expected.reference_error;
      reference_errors_.push_back(wrong);
      if (wrong > 1e-6 && wrong > 10.0 * says)
        complain(seed, fmt::format("the reference is {:.1e} off, and says {:.1e}", wrong, says), random);
    }
    for (const auto& [name, solver] : kSteppedAlone)
      add(seed, random, name, solver, play(random, solver, 1, start), expected);
    add_choice(seed, needed(random), expected);
  }

  int print() const {
    fmt::print(
        "| solver | compared | refused | not finite | energy grows | reference in doubt | reported error too "
        "small | median ratio | median error | 90 % below |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
    for (const char* name : {"explicit", "passive", "implicit", "exact", "auto"}) {
      const auto& tally = tallies_.at(name);
      fmt::print("| `{}` | {} | {} | {} | {} | {} | {} | {:.3f} | {:.1e} | {:.1e} |\n", name, tally.compared,
                 tally.refused, tally.infinite, tally.gains(), tally.doubtful, tally.too_small,
                 median(tally.ratios), median(tally.errors), quantile(tally.errors, 0.9));
    }
    fmt::print(
        "\n{} networks, {} without a solution to compare with, {} that the reference cannot follow; it is "
        "off by {:.1e} (median) and {:.1e} (99 %).\n",
        networks_, without_truth_, unsolved_, median(reference_errors_), quantile(reference_errors_, 0.99));
    print_choices();
    return complaints_ == 0 ? 0 : 1;
  }

 private:
  static constexpr std::pair<const char*, Solver> kSteppedAlone[] = {{"explicit", Solver::Explicit},
                                                                     {"passive", Solver::Passive},
                                                                     {"implicit", Solver::Implicit},
                                                                     {"exact", Solver::Exact}};

  static void print(const char* name, const Choices& c) {
    const auto share = [&](int count) { return c.networks > 0 ? 100.0 * count / c.networks : 0.0; };
    fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {} of {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", name,
               c.networks, share(c.bounded), share(c.good), c.worse, c.compared, median(c.costs),
               quantile(c.costs, 0.9), quantile(c.costs, 1.0), median(c.over_passive));
  }

  void print_choices() const {
    fmt::print(
        "\n| `auto` | networks | bounded | by at most 1 % | of these, path off by more | multiplications "
        "over the "
        "cheapest's, median | 90 % below | largest | over one step of `passive`, median |\n"
        "|---|---|---|---|---|---|---|---|---|\n");
    print("nothing slips", choices_[0]);
    print("with friction or plectra", choices_[1]);
    fmt::print("\nOf {} first stops and slips {} are outside of their bound.\n", choices_[1].events,
               choices_[1].early_or_late);
  }

  void add(std::uint64_t seed, const RandomNetwork& random, const std::string& name, Solver solver,
           const Played& played, const Expected& expected) {
    auto& tally = tallies_[name];
    if (played.refused) return void(++tally.refused);
    const bool may_explode = name == "explicit";
    tally.infinite += !played.finite;
    tally.gained += played.makes_energy();
    tally.most_gained = std::max(tally.most_gained, played.gained);
    if (!may_explode && !played.finite) complain(seed, name + " is not finite", random);
    if (!may_explode && solver != Solver::Explicit && played.makes_energy())
      complain(seed, fmt::format("{} makes energy: {:.1e} more", name, played.gained), random);
    if (!expected.solved() || !expected.truth || !played.finite) return;
    const double reported = apart(played.path, expected.reference),
                 actual = apart(played.path, *expected.truth);
    ++tally.compared;
    tally.errors.push_back(actual);
    if (reported < 10.0 * expected.reference_error) return void(++tally.doubtful);
    tally.ratios.push_back(reported / std::max(actual, 1e-12));
    // The solution to compare with is right to 1e-9 itself.
    if (actual > 1.05 * reported + 1e-8) {
      ++tally.too_small;
      complain(seed, fmt::format("{} reports {:.2e}, and is {:.2e} off", name, reported, actual), random);
    }
  }

  void add_choice(std::uint64_t seed, const RandomNetwork& random, const Expected& expected) {
    const auto choice = choose_solver(random.elements, random.rate, 0);
    const auto played = play(random, choice.solver, choice.oversample, start_energy(random));
    add(seed, random, "auto", choice.solver, played, expected);
    const auto chosen = std::ranges::find_if(choice.candidates, [&](const SolverBounds& candidate) {
      return candidate.solver == choice.solver && candidate.oversample == choice.oversample;
    });
    auto& choices = choices_[may_slip(random.elements) ? 1 : 0];
    ++choices.networks;
    if (chosen == choice.candidates.end() || !chosen->bounded()) return;
    ++choices.bounded;
    if (chosen->slip_frames > 0.0 && expected.solved()) {
      const Slipping slipping{random.elements, random.rate, random.frames,
                              [&](int frame) { return random.signal(frame); }};
      const double late = first_event_error(slipping, chosen->solver, chosen->oversample, chosen->slip_error);
      ++choices.events;
      choices.early_or_late += late > chosen->slip_frames;
      if (late > chosen->slip_frames)
        complain(seed,
                 fmt::format("auto: a friction or plectrum stops or slips {:.1f} frames off, bound {:.1f}",
                             late, chosen->slip_frames),
                 random);
    }
    if (!(std::max(chosen->error, chosen->slip_error) <= kGoodEnough)) return;
    ++choices.good;
    if (!expected.clear()) return;
    ++choices.compared;
    choices.worse += apart(played.path, expected.path()) > kGoodEnough;
    const auto all = all_candidates(random);
    choices.costs.push_back(chosen->multiplications / cheapest(random, all, *chosen, expected));
    const auto passive = std::ranges::find_if(
        all, [](const SolverBounds& c) { return c.solver == Solver::Passive && c.oversample == 1; });
    if (passive != all.end())
      choices.over_passive.push_back(chosen->multiplications / passive->multiplications);
  }

  /// Multiplications of what is right within 1 %, up to those of the choice.
  static double cheapest(const RandomNetwork& random, const std::vector<SolverBounds>& all,
                         const SolverBounds& chosen, const Expected& expected) {
    for (const auto& candidate : all) {
      if (candidate.multiplications >= chosen.multiplications) break;
      const auto played = play(random, candidate.solver, candidate.oversample, 0.0);
      if (played.finite && apart(played.path, expected.path()) <= kGoodEnough)
        return candidate.multiplications;
    }
    return chosen.multiplications;
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

  std::map<std::string, Tally> tallies_;
  Choices choices_[2];  ///< where nothing slips, and where something may
  std::vector<double> reference_errors_;
  int networks_ = 0, without_truth_ = 0, unsolved_ = 0, complaints_ = 0;
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
