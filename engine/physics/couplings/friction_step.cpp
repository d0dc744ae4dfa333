#include "engine/physics/couplings/friction_step.h"

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

/// The largest speed v in (0, free] where  v (1 + y c) + y N mu(v) = free;  below 0 if there is none. The
/// left side is convex, so Newton's steps from the right come down to its last root and never pass it.
double sliding_speed(const FrictionLaw& law, double viscous, double normal, double free,
                     double mobility) noexcept {
  constexpr int kMostSteps = 60;
  const double own = 1.0 + mobility * viscous, slowing = mobility * normal;
  double v = free / own;
  for (int i = 0; i < kMostSteps; ++i) {
    const double excess = v * own + slowing * law.coefficient(v) - free;
    if (excess <= 0.0) return v;
    const double slope = own + slowing * law.slope(v);
    if (slope <= 0.0) return -1.0;
    const double next = v - excess / slope;
    if (next <= 0.0) return -1.0;
    if (v - next <= 1e-15 * v) return next;
    v = next;
  }
  return v;
}

double sign_of(double x) noexcept { return x < 0.0 ? -1.0 : 1.0; }

/// The mean velocity of a step, or the nearest one whose force gives no more than `heat`.
double with_losses(double free, double mean, double mobility, double heat) noexcept {
  if (!((free - mean) * mean < -mobility * heat)) return mean;
  const double root = std::sqrt(free * free + 4.0 * mobility * heat);
  return 0.5 * (free + (mean > 0.0 ? root : -root));
}

/// A step, seen in the direction of `sign`.
class Rubbing {
 public:
  Rubbing(const FrictionLaw& law, double viscous, const FrictionStep& step, double sign) noexcept
      : law_(law),
        viscous_(viscous),
        step_(step),
        sign_(sign),
        free_(sign * step.free),
        before_(sign * step.before),
        jump_(sign * step.jump),
        holding_(step.normal * law.holding()) {}

  /// It held before; `sign` is that of the force which it would need.
  FrictionForce from_rest() const noexcept {
    const double y = step_.mobility, needed = free_ / y;
    const double load = needed - jump_ * (step_.centred ? 0.5 : 1.0) / y, margin = holding_ - std::abs(load);
    if (needed <= holding_) return hold(margin);
    if (step_.clings) return push(holding_);
    if (margin >= 0.0 || std::abs(jump_) > y * holding_) return slip_at_jump(load);
    return break_away(load, margin);
  }

  /// It slid before, in the direction of `sign`.
  FrictionForce moving(double before) const noexcept {
    const double y = step_.mobility, load = (free_ - before) / y, driven = load + step_.memory.owed;
    const double v = speed(free_ + y * step_.memory.owed, 1.0);
    if (v > 0.0 && 2.0 * v >= before) {
      const bool away = v > before && runs_away(before, 1.0);
      return slide(away ? 0.5 * (before + run_away(before, driven, driven, 1.0)) : v, before);
    }
    if (std::abs(load) <= holding_) return stop(before, load);
    // A stiff viscous part: the law of the velocity at the end.
    if (load > 0.0) return move(0.5 * (before + std::max(0.0, speed(2.0 * free_ - before, 2.0))), before);
    const double rest = 1.0 - std::min(1.0, stopped_after(before, load));
    return move(0.5 * before - std::max(0.0, speed(-y * rest * load, rest)), before);
  }

 private:
  /// The mean speed of what slides in a part of the step.
  double speed(double free, double part) const noexcept {
    return sliding_speed(law_, viscous_, step_.normal, free, part * step_.mobility);
  }

  /// Whether the friction falls so fast with the speed that a part of the step is many times as long as what
  /// that takes.
  bool runs_away(double v, double part) const noexcept {
    return -2.0 * part * step_.mobility * step_.normal * law_.slope(v) > 0.5;
  }
  double resistance(double v) const noexcept { return step_.normal * law_.coefficient(v) + viscous_ * v; }

  /// The speed at the end of a part of the step under a force on a line, by shorter steps of Runge's method.
  double run_away(double v, double from, double to, double part) const noexcept {
    constexpr double kMostSteps = 32.0;
    const double y = 2.0 * part * step_.mobility;
    const double steps = std::min(kMostSteps, std::ceil(-4.0 * y * step_.normal * law_.slope(v)));
    for (double i = 0.0; i < steps; ++i) {
      const double force = from + (to - from) * i / steps, middle = force + 0.5 * (to - from) / steps;
      const double half = std::max(0.0, v + 0.5 * y / steps * (force - resistance(v)));
      v = std::max(0.0, v + y / steps * (middle - resistance(half)));
    }
    return v;
  }

  FrictionForce hold(double margin) const noexcept {
    const double mean = step_.centred ? 0.5 * before_ : 0.0;
    return {sign_ * (free_ - mean) / step_.mobility, 0.0, 0.0, {.margin = std::max(0.0, margin)}};
  }

  FrictionForce push(double force) const noexcept {
    const double mean = free_ - step_.mobility * force;
    return {
        sign_ * force, sign_ * mean, sign_ * (2.0 * mean - before_), {.margin = FrictionMemory::kUnknown}};
  }

  FrictionForce break_away(double load, double margin) const noexcept {
    const double known = step_.memory.margin, grown = known - margin;
    const double part = known < 0.0 ? 1.0 : 0.5 - margin / grown;
    const double drive = known < 0.0 ? std::abs(load) : holding_ + 0.5 * part * grown;
    const double v = runs_away(0.0, part) ? 0.5 * run_away(0.0, known < 0.0 ? drive : holding_,
                                                           known < 0.0 ? drive : 2.0 * drive - holding_, part)
                                          : std::max(0.0, speed(step_.mobility * part * drive, part));
    return slide(std::max(v, least_speed()), before_);
  }

  /// No friction slows it further, however driven points change their speeds.
  double least_speed() const noexcept { return free_ - step_.mobility * holding_; }

  /// Driven points change their speeds so much that it slides from there on: either at once, or halfway.
  /// Until then it holds, or pushes with all that it can hold with.
  FrictionForce slip_at_jump(double load) const noexcept {
    const double y = step_.mobility;
    if (!step_.centred) {
      const double way = sign_of(step_.jump);
      return Rubbing(law_, viscous_, step_, way).moving(way * step_.jump);
    }
    const double first = std::clamp(load, -holding_, holding_), start = jump_ + y * (load - first),
                 end = 2.0 * free_ - before_ - y * first, way = sign_of(start);
    const FrictionStep half{.normal = step_.normal, .free = 0.5 * (start + end), .mobility = 0.5 * y};
    const double force = 0.5 * (first + Rubbing(law_, viscous_, half, way).moving(way * start).force);
    return move(free_ - y * force, before_);
  }

  FrictionForce slide(double v, double before) const noexcept {
    const double slower = std::min(v, std::max(0.0, free_));
    auto found = move(slower, before);
    found.memory.owed = (v - slower) / step_.mobility;
    return found;
  }

  /// The part of the step after which it stops.
  double stopped_after(double before, double load) const noexcept {
    return before / (2.0 * step_.mobility * (resistance(0.5 * before) - load));
  }

  FrictionForce stop(double before, double load) const noexcept {
    const double part = step_.centred ? 1.0 : std::min(1.0, stopped_after(before, load));
    const double mean = 0.5 * part * before;
    auto found = move(mean, before);
    if (found.velocity == sign_ * mean) found.after = 0.0;
    return found;
  }

  /// A force that gives energy gives no more than the slide has lost.
  FrictionForce move(double mean, double before) const noexcept {
    const double y = step_.mobility, heat = step_.memory.heat;
    mean = with_losses(free_, mean, y, heat);
    const double force = (free_ - mean) / y;
    return {sign_ * force,
            sign_ * mean,
            sign_ * (2.0 * mean - before),
            {.margin = FrictionMemory::kUnknown, .heat = std::max(0.0, heat + force * mean)}};
  }

  const FrictionLaw& law_;
  double viscous_;
  const FrictionStep& step_;
  double sign_, free_, before_, jump_, holding_;
};

}  // namespace

FrictionForce solve_friction(const FrictionLaw& law, double viscous, FrictionStep step) noexcept {
  step.normal = std::max(0.0, step.normal);
  const bool still = step.free == 0.0 && step.before == 0.0;
  // Below half a unit in the last place of 1 a viscous part changes no velocity.
  const bool rubs = step.normal != 0.0 || 1.0 + step.mobility * viscous != 1.0;
  if (step.mobility <= 0.0 || !rubs) {
    if (still) return {.memory = {.margin = FrictionMemory::kUnknown}};
    const double v = std::abs(step.free), force = step.normal * law.coefficient(v) + viscous * v;
    return {std::copysign(force, step.free),
            step.free,
            2.0 * step.free - step.before,
            {.margin = FrictionMemory::kUnknown}};
  }
  if (step.holds) return Rubbing(law, viscous, step, sign_of(step.free)).from_rest();
  const double sign = sign_of(step.before != 0.0 ? step.before : step.free);
  return Rubbing(law, viscous, step, sign).moving(sign * step.before);
}

FrictionForce start_friction(const FrictionLaw& law, double viscous, const FrictionStep& step,
                             double start) noexcept {
  auto half = step;
  const double end = 2.0 * step.free - step.before, heat = step.memory.heat;
  half.before = start, half.free = 0.5 * (start + end), half.mobility = 0.5 * step.mobility, half.jump = 0.0;
  half.memory.margin = FrictionMemory::kUnknown;
  auto found = solve_friction(law, viscous, half);
  found.force *= 0.5;
  if (step.mobility <= 0.0 || (step.holds && found.after == 0.0)) return found;
  // The energy that it gives or takes is that of the whole step, as of all other forces.
  const double mean = step.free - step.mobility * found.force,
               slower = with_losses(step.free, mean, step.mobility, heat);
  if (slower != mean) {
    found.force = (step.free - slower) / step.mobility;
    found.velocity = slower, found.after = 2.0 * slower - step.before;
  }
  found.memory.heat = std::max(0.0, heat + found.force * slower);
  return found;
}

}  // namespace tactus
