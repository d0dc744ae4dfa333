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

/// A quantity of a device, as scenes, options and reports name it.
struct DeviceQuantity {
  const char *role, *option, *key, *unit;
  double least;
  double WallDevice::*value;
  const char* doc;
};
inline constexpr DeviceQuantity kDeviceQuantities[] = {
    {"device_mass", "device-mass", "mass_kg", "kg", 1e-6, &WallDevice::mass,
     "moving mass of the device; such as \"9 g\""},
    {"device_damping", "device-damping", "damping_n_s_per_m", "N s/m", 0, &WallDevice::damping,
     "viscous damping of the device; such as \"0.05 N s/m\""},
    {"device_friction", "device-friction", "friction_n", "N", 0, &WallDevice::friction,
     "dry friction of the device, such as \"0.2 N\""},
    {"encoder_step", "step", "step_m", "m", 0, &WallDevice::quantum,
     "step of the position encoder, such as \"0.157 mm\""},
    {"force_limit", "force-limit", "force_limit_n", "N", 1e-3, &WallDevice::force_limit,
     "largest force of the motor, such as \"6.37 N\""}};

/// The device that a scene describes.
struct SceneDevice {
  WallDevice bare;
  WallDevice hand{.mass = 0, .damping = 0};  ///< of the hand in this scene

  WallDevice held() const { return bare.held(hand.mass, hand.damping); }
};
/// Reads the controls with the roles of `kDeviceQuantities`, `hand_mass` and `hand_damping`, as the scene
/// sets them, else as the part's file does. All but the first two may be missing. Errors: Missing; WrongType
/// where the scene moves one of them by a gesture or an expression.
Result<SceneDevice> device_of(const SceneSpec& scene);

/// A device on the map, bare or in a hand.
struct MappedDevice {
  std::string name;
  WallDevice device;
};

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

/// Hardware that renders walls, with its rate and delay.
struct WallController {
  std::string name;
  Hertz rate;
  Seconds delay;
  int bits = 0;                        ///< of its integers; 0: it has floating point
  std::vector<WallLimit> limits = {};  ///< one for each device
  std::optional<FixedPoint> fixed_point = {};
};

/// Berdahl, Steiner, Oldham, NIME 2008, table 2; 4 ms: the best of section 5.3; 20 ms: the Cellomobo, section
/// 7.2, at the rate of its sound card.
std::vector<WallController> controllers_of_the_paper();

struct WallStudy {
  std::vector<MappedDevice> devices;
  std::vector<WallController> controllers;  ///< without limits
  Hertz rate = 20_kHz;                      ///< of the walls over the delay
  double damping = 0;                       ///< B of all loops [N s/m]
  int points_per_decade = 8;
};

/// A study and its results.
struct WallMap : WallStudy {
  std::vector<std::vector<WallLimit>> by_delay = {};  ///< [device][point]: 0.02 to 40 ms
  std::vector<std::vector<WallLimit>> by_rate = {};   ///< the same: 250 Hz to 192 kHz, one frame of delay
  double friction_limit = 0;                          ///< 2 f_c / Delta of the first device
  std::ptrdiff_t runs = 0, finished = 0;              ///< points of the map, and those computed
  int borders = 0;                                    ///< how many were simulated on both sides
  int confirmed = 0;                                  ///< how many of these were confirmed
};

/// Computes every border and simulates the loop on both sides of it: a sweep over device, rate and delay.
/// Errors: BadFile of the cache.
Checked<WallMap> map_walls(const WallStudy& study, const RunPlan& plan = {});

}  // namespace tactus
