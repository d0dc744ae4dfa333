#include "engine/study/walls/wall_simulation.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace tactus {
namespace {

/// Rounds to the nearest step, halves upwards, as a counter of edges half a step off the middle does.
double counts_of(double position, double quantum) { return std::floor(position / quantum + 0.5); }

}  // namespace

WallSimulation::WallSimulation(const WallRun& run, double position, double velocity)
    : run_(run),
      delay_(run.loop.delay, run.loop.rate),
      early_s_(delay_.fraction * run.loop.period()),
      late_s_(run.loop.period() - early_s_),
      early_(HeldMass::over(run.device.mass, run.device.damping, early_s_)),
      late_(HeldMass::over(run.device.mass, run.device.damping, late_s_)),
      demanded_before_(static_cast<std::size_t>(delay_.whole) + 2, 0.0),
      position_(position),
      velocity_(velocity),
      last_read_(position) {
  if (run.bits == 0) return;
  assert(run.device.quantum > 0 && std::isfinite(run.device.force_limit));
  const double step = std::ldexp(run.device.force_limit, 1 - run.bits);
  stiffness_steps_ = std::round(run.stiffness * run.device.quantum / step);
  damping_steps_ = std::round(run.loop.damping * run.loop.rate.value * run.device.quantum / step);
  last_read_ = counts_of(position, run.device.quantum);
}

void WallSimulation::step() {
  demanded_ = controller_force();
  const auto size = demanded_before_.size();
  const auto whole = static_cast<std::size_t>(delay_.whole);
  demanded_before_[frame_ % size] = demanded_;
  const double older = demanded_before_[(frame_ + size - whole - 1) % size];
  const double newer = demanded_before_[(frame_ + size - whole) % size];
  ++frame_;
  if (delay_.fraction > 0) move(early_, early_s_, older);
  move(late_, late_s_, newer);
}

double WallSimulation::controller_force() {
  const double quantum = run_.device.quantum;
  const double counts = quantum > 0 ? counts_of(position_, quantum) : 0;
  if (run_.bits > 0) {
    const double force = integer_force(counts);
    last_read_ = counts;
    return force;
  }
  const double read = quantum > 0 ? counts * quantum : position_;
  const double speed = (read - last_read_) * run_.loop.rate.value;
  last_read_ = read;
  double force = -(run_.stiffness * read + run_.loop.damping * speed);
  if (run_.one_sided) force = read > 0 ? std::min(0.0, force) : 0.0;
  return std::clamp(force, -run_.device.force_limit, run_.device.force_limit);
}

double WallSimulation::integer_force(double counts) const {
  const double full = std::ldexp(1.0, run_.bits - 1);
  double steps = -(stiffness_steps_ * counts + damping_steps_ * (counts - last_read_));
  if (run_.one_sided) steps = counts > 0 ? std::min(0.0, steps) : 0.0;
  return std::clamp(steps, -full, full - 1) * run_.device.force_limit / full;
}

void WallSimulation::move(const HeldMass& held, double seconds, double force) {
  force += run_.push;
  if (run_.device.friction > 0) return move_with_friction(seconds, force);
  position_ += held.reach * velocity_ + held.rise * force;
  velocity_ = held.keep * velocity_ + held.gain * force;
}

void WallSimulation::move_with_friction(double seconds, double force) {
  const auto& device = run_.device;
  while (seconds > 0) {
    if (velocity_ == 0 && std::abs(force) <= device.friction) return;
    const double way = velocity_ != 0 ? std::copysign(1.0, velocity_) : std::copysign(1.0, force);
    const double sum = force - way * device.friction;
    // The speed v e^-at + (sum/b) (1 - e^-at) is 0 where e^at = 1 - v b / sum.
    double part = seconds;
    const bool slows = velocity_ != 0 && sum * way < 0;
    if (slows) {
      const double y = -velocity_ * device.damping / sum;
      const double stop =
          y > 1e-12 ? std::log1p(y) * device.mass / device.damping : -velocity_ * device.mass / sum;
      part = std::min(part, stop);
    }
    const auto held = HeldMass::over(device.mass, device.damping, part);
    position_ += held.reach * velocity_ + held.rise * sum;
    velocity_ = slows && part < seconds ? 0.0 : held.keep * velocity_ + held.gain * sum;
    seconds -= part;
  }
}

LoopTrend trend_of(WallSimulation simulation, Hertz cycle, Hertz rate, double most_frames) {
  constexpr double kCycles = 8, kClear = 1.5;
  const auto window = std::max(1.0, std::round(kCycles * (rate / cycle)));
  double first = 0;
  for (double done = 0, windows = 0; done < most_frames; done += window, ++windows) {
    double sum = 0;
    for (double n = 0; n < window; ++n) {
      simulation.step();
      sum += simulation.position() * simulation.position();
    }
    if (windows == 1) first = sum;
    if (windows < 2) continue;
    if (sum > kClear * first) return LoopTrend::Grows;
    if (sum * kClear < first) return LoopTrend::Decays;
  }
  return LoopTrend::Undecided;
}

}  // namespace tactus
