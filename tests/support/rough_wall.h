#pragma once

#include <cmath>
#include <vector>

#include "engine/study/walls/virtual_wall.h"

namespace tactus::test {

/// A spring that is rendered to a device with dry friction, in a hand that leans on it: frame by frame, by
/// the exact solution between the instants at which the force changes. A phase of motion ends where the speed
/// reaches 0, and the device then sticks while |F| <= f_c. The delay is a whole number of frames.
class RoughWall {
 public:
  RoughWall(const WallDevice& device, const WallLoop& loop, double stiffness, double push, double position,
            double velocity = 0)
      : device_(device),
        period_(loop.period()),
        stiffness_(stiffness),
        push_(push),
        forces_(static_cast<std::size_t>(std::lround(frames_in(loop.delay, loop.rate))) + 1, 0.0),
        position_(position),
        velocity_(velocity) {}

  void step() {
    const double quantum = device_.quantum;
    const double read = quantum > 0 ? quantum * std::floor(position_ / quantum + 0.5) : position_;
    forces_[frame_ % forces_.size()] = -stiffness_ * read;
    move(push_ + forces_[++frame_ % forces_.size()]);
  }
  double position() const { return position_; }
  double velocity() const { return velocity_; }

 private:
  void move(double force) {
    for (double seconds = period_; seconds > 0;) {
      if (velocity_ == 0 && std::abs(force) <= device_.friction) return;
      const double way = velocity_ != 0 ? std::copysign(1.0, velocity_) : std::copysign(1.0, force);
      const double sum = force - way * device_.friction;
      // The speed v e^-at + (sum/b) (1 - e^-at) is 0 where e^at = 1 - v b / sum.
      double part = seconds;
      const bool slows = velocity_ != 0 && sum * way < 0;
      if (slows) {
        const double y = -velocity_ * device_.damping / sum;
        const double stop =
            y > 1e-12 ? std::log1p(y) * device_.mass / device_.damping : -velocity_ * device_.mass / sum;
        part = std::min(part, stop);
      }
      const auto held = HeldMass::over(device_.mass, device_.damping, part);
      position_ += held.reach * velocity_ + held.rise * sum;
      velocity_ = slows && part < seconds ? 0.0 : held.keep * velocity_ + held.gain * sum;
      seconds -= part;
    }
  }

  WallDevice device_;
  double period_, stiffness_, push_;
  std::vector<double> forces_;  // ring
  std::size_t frame_ = 0;
  double position_, velocity_;
};

}  // namespace tactus::test
