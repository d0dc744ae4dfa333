#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/scene/file/scene_spec.h"
#include "engine/study/sweep/evaluate_runs.h"
#include "engine/study/walls/virtual_wall.h"
#include "engine/study/walls/wall_simulation.h"

namespace tactus {

/// The device that the plant of a scene describes.
struct SceneDevice {
  WallDevice bare;
  double hand_mass = 0, hand_damping = 0;  ///< of the hand in this scene [kg, N s/m]

  WallDevice held() const { return bare.held(hand_mass, hand_damping); }
};
/// Reads the plant's controls `mass`, `damping`, `friction`, `step` (of its encoder), `force_limit`,
/// `hand_mass` and `hand_damping`, as the scene sets them, else as the plant's file does. All but the first
/// two may be missing. Errors: Missing; WrongType where the scene moves one of them by a gesture or an
/// expression.
Result<SceneDevice> device_of(const SceneSpec& scene);

/// A device on the map, bare or in a hand.
struct MappedDevice {
  std::string name;
  WallDevice device;
};

/// Hardware that renders walls, with its rate and delay.
struct WallController {
  std::string name;
  Hertz rate;
  Seconds delay;
  int bits = 0;  ///< of its integers; 0: it has floating point
};

/// Berdahl, Steiner, Oldham, NIME 2008, table 2; 4 ms: the best of section 5.3; 20 ms: the Cellomobo, section
/// 7.2, at the rate of its sound card.
std::vector<WallController> controllers_of_the_paper();

/// The stiffest wall of a device under a loop, and the trend of the simulation on either side of it.
struct WallLimit {
  WallLoop loop;
  double stiffest = 0;                                                   ///< exact [N/m]
  double formula = 0;                                                    ///< (b + B) / (T/2 + tau_d)
  double passive = 0;                                                    ///< (b - |B|) / (T/2 + tau_d)
  Hertz cycle = {};                                                      ///< of the oscillation at the border
  LoopTrend below = LoopTrend::Undecided, above = LoopTrend::Undecided;  ///< at 0.98 and 1.02 of it

  bool confirmed() const { return below == LoopTrend::Decays && above == LoopTrend::Grows; }
};

/// Effects of integer arithmetic on a wall.
struct FixedPoint {
  double force_step;      ///< F_max / 2^(bits - 1) [N]
  double stiffness_step;  ///< force_step / Delta [N/m]: gains are whole steps a count
  double full_depth;      ///< at which the stiffest wall reaches the motor's limit [m]
  double with_encoder;    ///< border in the simulation with the encoder's steps alone [N/m]
  double with_bits;       ///< and with integers besides [N/m]
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
  std::vector<MappedController> controllers;     ///< fixed_point: of the first device
  double friction_limit = 0;                     ///< 2 f_c / Delta of the first device
  std::ptrdiff_t runs = 0, finished = 0;         ///< points of the map, and those computed
  int borders = 0;                               ///< how many were simulated on both sides
  int confirmed = 0;                             ///< how many of these were confirmed
};

struct WallStudy {
  std::vector<MappedDevice> devices;
  std::vector<WallController> controllers;
  Hertz rate = 20_kHz;
  double damping = 0;  ///< B of all loops [N s/m]
  int points_per_decade = 8;
};

/// Computes every border and simulates the loop on both sides of it: a sweep over device, rate and delay.
/// Errors: BadFile of the cache.
Checked<WallMap> map_walls(const WallStudy& study, const RunPlan& plan = {});

}  // namespace tactus
