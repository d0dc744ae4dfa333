#pragma once
// Thread: [control]

#include <cstddef>
#include <vector>

#include "engine/study/walls/virtual_wall.h"

namespace tactus {

/// A loop to run in time.
struct WallRun {
  WallDevice device = {};
  WallLoop loop = {};
  double stiffness = 0;  ///< K [N/m]
  /// The controller computes in integers of this many bits: position in counts, gains in force steps per
  /// count, force in steps of F_max / 2^(bits - 1). 0: floating point. Needs Delta > 0 and a finite F_max.
  int bits = 0;
};

/// Device, sensor, controller, delay and hold, frame by frame. Between the instants at which the force
/// changes, the device moves by its exact solution (HeldMass), without its friction. It is independent of
/// the formulas that it confirms.
class WallSimulation {
 public:
  WallSimulation(const WallRun& run, double position, double velocity);

  /// One frame: reads the sensor, gives the force, moves the device to the next frame.
  void step();

  double position() const { return position_; }  ///< [m]
  double velocity() const { return velocity_; }  ///< [m/s]

 private:
  double controller_force();
  double integer_force(double counts) const;
  void move(const HeldMass& held, double force);

  WallRun run_;
  SplitDelay delay_;
  HeldMass early_, late_;  ///< before and after the force changes within a frame
  double stiffness_steps_ = 0, damping_steps_ = 0;
  std::vector<double> demanded_before_;  ///< ring
  std::size_t frame_ = 0;
  double position_, velocity_, last_read_;
};

enum class LoopTrend { Decays, Grows, Undecided };

/// [control] Runs a loop: whether the sum of x^2 over 8 cycles falls below or rises above that
/// of the first such window (after one for the start) by half. `cycle`: its frequency, about.
/// Undecided after `most_frames`.
LoopTrend trend_of(WallSimulation simulation, Hertz cycle, Hertz rate, double most_frames = 3e8);

}  // namespace tactus
