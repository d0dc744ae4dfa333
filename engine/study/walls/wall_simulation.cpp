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
      early_(HeldMass::over(run.device.mass, run.device.damping, delay_.fraction * run.loop.period())),
      late_(HeldMass::over(run.device.mass, run.device.damping,
                           run.loop.period() - delay_.fraction * run.loop.period())),
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
  const auto size = demanded_before_.size();
  const auto whole = static_cast<std::size_t>(delay_.whole);
  demanded_before_[frame_ % size] = controller_force();
  const double older = demanded_before_[(frame_ + size - whole - 1) % size];
  const double newer = demanded_before_[(frame_ + size - whole) % size];
  ++frame_;
  if (delay_.fraction > 0) move(early_, older);
  move(late_, newer);
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
  return std::clamp(-(run_.stiffness * read + run_.loop.damping * speed), -run_.device.force_limit,
                    run_.device.force_limit);
}

double WallSimulation::integer_force(double counts) const {
  const double full = std::ldexp(1.0, run_.bits - 1);
  const double steps = -(stiffness_steps_ * counts + damping_steps_ * (counts - last_read_));
  return std::clamp(steps, -full, full - 1) * run_.device.force_limit / full;
}

void WallSimulation::move(const HeldMass& held, double force) {
  position_ += held.reach * velocity_ + held.rise * force;
  velocity_ = held.keep * velocity_ + held.gain * force;
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
