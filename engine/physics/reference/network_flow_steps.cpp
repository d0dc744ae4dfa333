#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/physics/reference/find_zero.h"
#include "engine/physics/reference/network_flow.h"

// Steps of a network with contacts. Each contact has a margin that stays above 0 while the equation of the
// step holds: of an open one how far it is from touching, of a pressing one how deep it is and how far its
// loss is from outweighing the push; so has each friction and each bond. A step in which a margin would
// fall below 0 is cut just behind that instant, and the link changes over.
namespace tactus {
namespace {

// More in one frame: the motion cannot be followed.
constexpr int kMostSteps = 200'000;
// Of a frame: what is left of it is nothing.
constexpr double kNothing = 1e-13;
// Of a step: how closely an event is located.
constexpr double kInstant = 1e-14;
// Slower motion, nearer to 0, is as good as rest. [m], [m/s], [A]
constexpr double kLeastPosition = 1e-9, kLeastVelocity = 1e-6, kLeastCurrent = 1e-9;
// So many times the tolerance may be the rounding of large forces that balance.
constexpr double kMostRounding = 1e4;

double largest(const double* numbers, std::size_t count) {
  double most = 0.0;
  for (std::size_t i = 0; i < count; ++i)
    if (!(std::abs(numbers[i]) <= most)) most = std::abs(numbers[i]);  // NaN is the largest
  return most;
}

}  // namespace

void NetworkFlow::integrate(State& state) const {
  double left_s = frame_s_;
  start_slides(state);
  for (int steps = 0; left_s > kNothing * frame_s_; ++steps) {
    double done_s = steps < kMostSteps ? try_step(state, left_s) : 0.0;
    if (done_s == 0.0)
      return std::fill(state.numbers.begin(), state.numbers.end(), std::numeric_limits<double>::quiet_NaN());
    done_s = until_event(state, until_turn(state, done_s));
    state.numbers.swap(state.next);
    left_s -= done_s;
    switch_over(state);
  }
}

/// The longest step that is good and not longer than `longest_s`, into `next`; 0: there is none.
double NetworkFlow::try_step(State& state, double longest_s) const {
  const auto slope = [&](double, const double* numbers, double* to) { rates(state, numbers, to); };
  const auto worst = [&](const double* numbers, const double* difference) {
    return error(numbers, difference);
  };
  double seconds = state.step_s > 0.0 ? std::min(state.step_s, longest_s) : longest_s;
  const double wanted_s = state.step_s;
  double last_s = 0.0, last_error = 0.0;
  while (seconds > kNothing * kNothing * frame_s_) {
    const auto outcome = state.extrapolation.step(slope, state.numbers.data(), seconds, worst);
    state.step_s = outcome.advised_s;
    // What shrinks no faster than the step is no error of the method.
    const bool rounding =
        outcome.error < kMostRounding && outcome.error * last_s > 0.5 * last_error * seconds && last_s > 0.0;
    if (outcome.good || rounding) {
      // The end of a frame says nothing about the step that follows.
      if (seconds == longest_s) state.step_s = std::max(state.step_s, wanted_s);
      state.next = state.extrapolation.result();
      return seconds;
    }
    last_s = std::exchange(seconds, outcome.advised_s);
    last_error = outcome.error;
  }
  return 0.0;
}

/// A shorter step than one that was good.
void NetworkFlow::step_again(State& state, double seconds) const {
  state.extrapolation.step(
      [&](double, const double* numbers, double* to) { rates(state, numbers, to); }, state.numbers.data(),
      seconds, [&](const double* numbers, const double* difference) { return error(numbers, difference); });
  state.next = state.extrapolation.result();
}

double NetworkFlow::error(const double* numbers, const double* difference) const {
  double most = 0.0;
  const auto judge = [&](std::size_t from, std::size_t count, double least) {
    const double wrong = largest(difference + from, count);
    if (wrong == 0.0) return;
    const double share = wrong / (tolerance_ * std::max(least, largest(numbers + from, count)));
    if (!(share <= most)) most = share;
  };
  judge(0, points(), kLeastPosition);
  judge(points(), points(), kLeastVelocity);
  judge(2 * points(), elements_.coils.size(), kLeastCurrent);
  return most;
}

double NetworkFlow::contact_margin(const State& state, const double* numbers, std::size_t contact) const {
  const double n = indentation_in(numbers, contact);
  if (state.touch[contact] == Touch::Open) return -n;
  const double push = 1.0 + state.loss[contact] * approach_in(numbers, contact);
  return std::min(n, state.touch[contact] == Touch::Pressing ? push : -push);
}

double NetworkFlow::least_margin(State& state, const double* numbers) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < laws_.size(); ++c) least = std::min(least, contact_margin(state, numbers, c));
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f)
    least = std::min(least, friction_margin(state, numbers, f));
  for (std::size_t b = 0; b < elements_.bonds.size(); ++b)
    least = std::min(least, bond_margin(state, numbers, b));
  return least;
}

/// Cuts the step to `next` behind the first event in it.
double NetworkFlow::until_event(State& state, double seconds) const {
  const double at_end = least_margin(state, state.next.data());
  if (!(at_end < 0.0)) return seconds;
  const auto margin_at = [&](double time) {
    if (time <= 0.0) return std::numeric_limits<double>::min();
    if (time == seconds) return at_end;
    step_again(state, time);
    const double least = least_margin(state, state.next.data());
    return least == 0.0 ? std::numeric_limits<double>::min() : least;  // not yet behind it
  };
  const auto event = find_zero(margin_at, 0.0, seconds, kInstant * seconds);
  const double behind = event.f_near < 0.0 ? event.near : event.far;
  step_again(state, behind);
  return behind;
}

/// A contact may touch, or part, and be back within a step: then the motion turns in it.
bool NetworkFlow::turns(const State& state, double seconds, std::size_t contact) const {
  const double before = approach_in(state.numbers.data(), contact);
  const double after = approach_in(state.next.data(), contact);
  const bool open = state.touch[contact] == Touch::Open;
  if (open ? !(before > 0.0 && after < 0.0) : !(before < 0.0 && after > 0.0)) return false;
  const double far = std::abs(indentation_in(state.numbers.data(), contact));
  return far < 2.0 * seconds * std::max(std::abs(before), std::abs(after));
}

/// Cuts the step to `next` where such a motion turns, so that the deepest point is the end of a step.
double NetworkFlow::until_turn(State& state, double seconds) const {
  for (std::size_t c = 0; c < laws_.size(); ++c) {
    if (!turns(state, seconds, c)) continue;
    const double before = approach_in(state.numbers.data(), c);
    const auto approach_at = [&](double time) {
      if (time <= 0.0) return before;
      step_again(state, time);
      const double approach = approach_in(state.next.data(), c);
      return approach == 0.0 ? std::copysign(std::numeric_limits<double>::min(), before) : approach;
    };
    const auto turn = find_zero(approach_at, 0.0, seconds, kInstant * seconds);
    seconds = (turn.f_near < 0.0) == (before < 0.0) ? turn.far : turn.near;
    step_again(state, seconds);
  }
  return seconds;
}

void NetworkFlow::switch_contact(State& state, std::size_t contact) const {
  const double* numbers = state.numbers.data();
  auto& touch = state.touch[contact];
  if (touch == Touch::Open) state.loss[contact] = start_loss(contact, approach_in(numbers, contact));
  if (indentation_in(numbers, contact) < 0.0)
    touch = Touch::Open;
  else
    touch = touch == Touch::Pressing ? Touch::LettingGo : Touch::Pressing;
}

void NetworkFlow::switch_over(State& state) const {
  const double* numbers = state.numbers.data();
  for (std::size_t c = 0; c < laws_.size(); ++c)
    if (contact_margin(state, numbers, c) < 0.0) switch_contact(state, c);
  for (std::size_t b = 0; b < elements_.bonds.size(); ++b) {
    if (!(bond_margin(state, numbers, b) < 0.0)) continue;
    auto& slide = state.slide[elements_.frictions.size() + b];
    const double n = between(numbers, elements_.bonds[b].lower, elements_.bonds[b].upper);
    slide = slide != Slide::Holds ? Slide::Holds : n > 0.0 ? Slide::Up : Slide::Down;
  }
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f)
    if (friction_margin(state, numbers, f) < 0.0) switch_friction(state, f);
}

}  // namespace tactus
