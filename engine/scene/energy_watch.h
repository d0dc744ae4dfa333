#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// What went through a port between instrument and plant [J].
struct PortEnergy : Port {
  double net = 0;                          ///< given to the plant over all; negative: taken out of it
  double given = 0;                        ///< most that it gave since any earlier moment
  std::optional<double> active_at_s = {};  ///< when `given` first exceeded `allowed`
  double growth_w = 0;                     ///< watts by which it rose on from there to its most
};

/// Adds up the energy that a motor gives to what it moves,
///     E[n] = E[n-1] + F[n] (x[n] - x[n-1]),   given = max over m < n of E[n] - E[m],
/// F[n] [N] the force that acted from frame n - 1 to n, as a network's outputs give it. Held from frame to
/// frame it does exactly this work, whatever the motion between. An instrument that only imitates springs,
/// masses and dampers gives back at most what it stores; one whose loop has turned active gives more and
/// more, and since `given` counts from the lowest moment, nothing that it took before can hide that. Source:
/// Hannaford & Ryu, "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics and Automation
/// 18, 2002.
class EnergyWatch {
 public:
  explicit EnergyWatch(Port port) : port_(std::move(port)) {}

  /// [realtime] The next frames. The block size does not matter.
  void take(const double* force, const double* position, int frames) noexcept;
  /// [any] What came of it so far.
  PortEnergy energy(Hertz sample_rate) const;

 private:
  Port port_;
  long long frame_ = 0, active_at_ = -1, most_at_ = 0;
  double position_ = 0, sum_ = 0, lowest_ = 0, given_ = 0, given_when_active_ = 0;
};

/// One watch for each port of a scene that plays.
class PortWatches {
 public:
  /// [control] `scene` passed check_ports. Keeps the places of its signals among the taps of the plant.
  PortWatches(const SceneSpec& scene, const std::vector<SceneTap>& plant_taps);

  /// [realtime] After each block.
  void take(const Player& plant, int frames) noexcept;
  std::vector<PortEnergy> energies(Hertz sample_rate) const;

 private:
  struct Watched {
    int force, position;  ///< taps
    EnergyWatch watch;
  };
  std::vector<Watched> watched_;
};

/// "arm: the loop turned active at 0.31 s: it gave 2.4 J where 0.05 J are allowed, 1.1 W on average from then
/// on"
std::string describe(const PortEnergy& energy);

}  // namespace tactus
