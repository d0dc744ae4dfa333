#include <algorithm>
#include <cmath>

#include "engine/physics/index.h"
#include "engine/physics/reference/network_flow.h"

// Links that hold or slide. A friction that holds pushes as hard as keeps its ends at one velocity, which is
// a linear system over all that hold; it slides when that takes more than N mu(0). One that slides has its
// law's force in the direction that it has slid so far, also a little past the instant at which it stops.
namespace tactus {
namespace {

// A driven point changes its speed from frame to frame; less than this is rounding. [m/s]
constexpr double kStill = 1e-12;
// How far past a stop the law goes on. [m/s]
constexpr double kPast = 1e-3;

/// K n^a, and the same with its sign changed below 0: smooth there, as a step that runs past an opening
/// needs.
double odd_force(const ContactLaw& law, double n) { return n < 0.0 ? -law.force(-n) : law.force(n); }

/// matrix x = b for `n` unknowns, symmetric and positive (semi)definite; the result in `b`.
void solve(double* matrix, double* b, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const double share = matrix[i * n + i] > 0.0 ? matrix[j * n + i] / matrix[i * n + i] : 0.0;
      for (std::size_t l = i; l < n; ++l) matrix[j * n + l] -= share * matrix[i * n + l];
      b[j] -= share * b[i];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t l = i + 1; l < n; ++l) b[i] -= matrix[i * n + l] * b[l];
    b[i] = matrix[i * n + i] > 0.0 ? b[i] / matrix[i * n + i] : 0.0;
  }
}

}  // namespace

double NetworkFlow::between(const double* numbers, int lower, int upper) const {
  return numbers[lower] - numbers[upper];
}

double NetworkFlow::push_in(const State& state, const double* numbers, std::size_t contact) const {
  if (state.touch[contact] != Touch::Pressing) return 0.0;
  return odd_force(laws_[contact], indentation_in(numbers, contact)) *
         (1.0 + state.loss[contact] * approach_in(numbers, contact));
}

double NetworkFlow::normal_in(const State& state, const double* numbers, std::size_t friction) const {
  const auto& f = elements_.frictions[friction];
  if (f.normal_contact >= 0) return std::max(0.0, push_in(state, numbers, index(f.normal_contact)));
  if (f.normal_spring >= 0) {
    const auto& s = elements_.springs[index(f.normal_spring)];
    const double* velocities = numbers + points();
    return std::max(0.0, s.stiffness * (numbers[s.upper] - numbers[s.lower] - s.rest) +
                             s.damping * (velocities[s.upper] - velocities[s.lower]));
  }
  const auto first = held() - 1 - elements_.frictions.size();
  return std::max(0.0, state.inputs[first + friction]);
}

double NetworkFlow::sliding_force(const State& state, const double* numbers, std::size_t friction,
                                  Slide slide) const {
  const auto& f = elements_.frictions[friction];
  const double v = between(numbers + points(), f.lower, f.upper), sign = slide == Slide::Up ? 1.0 : -1.0;
  return sign * normal_in(state, numbers, friction) * f.law.coefficient(std::max(sign * v, -kPast)) +
         f.viscous * v;
}

double NetworkFlow::bond_in(const State& state, const double* numbers, std::size_t bond) const {
  if (state.slide[elements_.frictions.size() + bond] != Slide::Holds) return 0.0;
  const auto& b = elements_.bonds[bond];
  return b.law->force(between(numbers, b.lower, b.upper)) +
         b.damping * between(numbers + points(), b.lower, b.upper);
}

void NetworkFlow::add_slides(const State& state, const double* numbers, double* force) const {
  const auto push = [force](const auto& link, double by) {
    force[link.lower] -= by;
    force[link.upper] += by;
  };
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f)
    if (state.slide[f] != Slide::Holds)
      push(elements_.frictions[f], sliding_force(state, numbers, f, state.slide[f]));
  for (std::size_t b = 0; b < elements_.bonds.size(); ++b)
    push(elements_.bonds[b], bond_in(state, numbers, b));
}

/// Adds the forces of the frictions that hold to those of all others: (x_lower - x_upper)'' = 0.
void NetworkFlow::hold(State& state, double* force) const {
  const auto n = elements_.frictions.size();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& a = elements_.frictions[i];
    const bool holds = state.slide[i] == Slide::Holds;
    state.hold[i] = holds ? force[a.lower] * inverse_mass_[index(a.lower)] -
                                force[a.upper] * inverse_mass_[index(a.upper)]
                          : 0.0;
    for (std::size_t j = 0; j < n; ++j) {
      const auto& b = elements_.frictions[j];
      const auto share = [&](int of_a, int of_b) { return of_a == of_b ? inverse_mass_[index(of_a)] : 0.0; };
      const double mutual = share(a.lower, b.lower) + share(a.upper, b.upper) - share(a.lower, b.upper) -
                            share(a.upper, b.lower);
      state.mutual[i * n + j] = holds && state.slide[j] == Slide::Holds ? mutual : 0.0;
    }
  }
  solve(state.mutual.data(), state.hold.data(), n);
  for (std::size_t i = 0; i < n; ++i) {
    force[elements_.frictions[i].lower] -= state.hold[i];
    force[elements_.frictions[i].upper] += state.hold[i];
  }
}

/// At the start of a frame driven points have new speeds, which what held to them has not.
void NetworkFlow::start_slides(State& state) const {
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f) {
    const auto& friction = elements_.frictions[f];
    const double v = between(state.numbers.data() + points(), friction.lower, friction.upper);
    if (state.slide[f] == Slide::Holds && std::abs(v) > kStill)
      state.slide[f] = v > 0.0 ? Slide::Up : Slide::Down;
  }
}

double NetworkFlow::friction_margin(State& state, const double* numbers, std::size_t friction) const {
  const auto& f = elements_.frictions[friction];
  if (state.slide[friction] != Slide::Holds) {
    const double v = between(numbers + points(), f.lower, f.upper);
    return state.slide[friction] == Slide::Up ? v : -v;
  }
  rates(state, numbers, state.slope.data());
  return normal_in(state, numbers, friction) * f.law.holding() - std::abs(state.hold[friction]);
}

double NetworkFlow::bond_margin(const State& state, const double* numbers, std::size_t bond) const {
  const auto& b = elements_.bonds[bond];
  const double n = between(numbers, b.lower, b.upper);
  const auto slide = state.slide[elements_.frictions.size() + bond];
  return slide == Slide::Holds ? b.law->distance_at(b.limit) - std::abs(n) : slide == Slide::Up ? n : -n;
}

/// Takes away what rounding has left of the velocity at a stop.
void NetworkFlow::halt(State& state, std::size_t friction) const {
  const auto lower = index(elements_.frictions[friction].lower);
  const auto upper = index(elements_.frictions[friction].upper);
  double* velocities = state.numbers.data() + points();
  const double v = velocities[lower] - velocities[upper], light = inverse_mass_[lower] + inverse_mass_[upper];
  if (light == 0.0) return;
  velocities[lower] -= v * inverse_mass_[lower] / light;
  velocities[upper] += v * inverse_mass_[upper] / light;
}

/// One that slid has stopped: it holds if it can. One that cannot hold any longer slides.
void NetworkFlow::switch_friction(State& state, std::size_t friction) const {
  halt(state, friction);
  state.slide[friction] = Slide::Holds;
  if (friction_margin(state, state.numbers.data(), friction) < 0.0)
    state.slide[friction] = state.hold[friction] > 0.0 ? Slide::Up : Slide::Down;
}

double NetworkFlow::friction_velocity(const State& state, int friction) const {
  const auto& f = elements_.frictions[index(friction)];
  return between(state.numbers.data() + points(), f.lower, f.upper);
}

/// Of one that holds: what it took when it was looked at last, at the end of the last step.
double NetworkFlow::friction_force(const State& state, int friction) const {
  const auto f = index(friction);
  return state.slide[f] == Slide::Holds ? state.hold[f]
                                        : sliding_force(state, state.numbers.data(), f, state.slide[f]);
}

double NetworkFlow::bond_force(const State& state, int bond) const {
  return bond_in(state, state.numbers.data(), index(bond));
}

}  // namespace tactus
