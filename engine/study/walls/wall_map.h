#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/study/walls/virtual_wall.h"
#include "engine/study/walls/wall_simulation.h"

namespace tactus {

/// A device on the map, bare or in a hand.
struct MappedDevice {
  std::string name;
  WallDevice device;
};

/// Who renders walls: hardware with its rate and delay.
struct WallController {
  std::string name;
  Hertz rate;
  Seconds delay;
  int bits = 0;  ///< of its whole numbers; 0: it has floating point
};

/// Berdahl, Steiner, Oldham, NIME 2008, table 2; 4 ms: the best of section 5.3; 20 ms: the Cellomobo, section
/// 7.2, at the rate of its sound card.
std::vector<WallController> controllers_of_the_paper();

/// The stiffest wall of a device under a loop, and what the simulation says on either side of it.
struct WallLimit {
  WallLoop loop;
  double stiffest = 0;                                                   ///< exact [N/m]
  double formula = 0;                                                    ///< (b + B) / (T/2 + tau_d)
  double passive = 0;                                                    ///< (b - |B|) / (T/2 + tau_d)
  Hertz cycle = {};                                                      ///< at which it swings on the border
  LoopTrend below = LoopTrend::Undecided, above = LoopTrend::Undecided;  ///< at 0.98 and 1.02 of it

  bool confirmed() const { return below == LoopTrend::Decays && above == LoopTrend::Grows; }
};

/// What whole numbers do to a wall.
struct FixedPoint {
  double force_step;      ///< F_max / 2^(bits - 1) [N]
  double stiffness_step;  ///< force_step / Delta [N/m]: gains are whole steps a count
  double full_depth;      ///< at which the stiffest wall reaches the motor's limit [m]
  double with_encoder;    ///< border that the simulation finds with the encoder's steps alone [N/m]
  double with_bits;       ///< and with whole numbers besides [N/m]
};

struct MappedController {
  WallController controller;
  std::vector<WallLimit> limits;  ///< one for each device
  std::optional<FixedPoint> fixed_point;
};

struct WallMap {
  std::vector<MappedDevice> devices;
  Hertz rate;                                    ///< of the walls over the delay
  std::vector<std::vector<WallLimit>> by_delay;  ///< [device][point]: 0.02 to 40 ms
  std::vector<std::vector<WallLimit>> by_rate;   ///< [device][point]: 250 Hz to 192 kHz, one frame of delay
  std::vector<MappedController> controllers;     ///< the first device counts its whole numbers
  double friction_limit = 0;                     ///< 2 f_c / Delta of the first device

  int borders() const;    ///< how many were tried on both sides
  int confirmed() const;  ///< and how many of them held
};

struct WallStudy {
  std::vector<MappedDevice> devices;
  std::vector<WallController> controllers;
  Hertz rate = 20_kHz;
  double damping = 0;  ///< B of all loops [N s/m]
  int points_per_decade = 8;
};

/// [control] Computes every border and runs the loop on both sides of it, on all cores. `progress` gets the
/// share done.
WallMap map_walls(const WallStudy& study, const std::function<void(double)>& progress = {});

}  // namespace tactus
