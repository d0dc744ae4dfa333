#pragma once
// Thread: [control]

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/index.h"
#include "engine/graph/semantics/interval.h"
#include "engine/rig/limits.h"
#include "engine/rig/profile.h"
#include "engine/study/stability/stability.h"
#include "latency/estimation/fourier.h"

namespace tactus::app {

/// The energy of a signal by frequency.
class Spectrum {
 public:
  Spectrum(const std::vector<double>& samples, double rate_hz) {
    Fourier fourier{samples.size()};
    bin_hz_ = rate_hz / static_cast<double>(fourier.size());
    double sum = 0.0;
    for (const auto& bin : fourier.forward(samples)) energy_.push_back(sum += std::norm(bin));
  }

  /// The frequencies with all but a twentieth of the energy at either end.
  Interval band() const {
    if (!(energy_.back() > 0)) return {0.0, 0.0};
    return {frequency(kBandShare), frequency(1.0 - kBandShare)};
  }
  /// Of the energy, at frequencies below `hz`.
  double share_below(double hz) const {
    const auto bins = static_cast<std::ptrdiff_t>(std::ceil(hz / bin_hz_));
    if (bins <= 0 || !(energy_.back() > 0)) return 0.0;
    return energy_[index(std::min(bins, std::ssize(energy_)) - 1)] / energy_.back();
  }

 private:
  static constexpr double kBandShare = 0.05;

  double frequency(double share) const {
    const auto bin = std::ranges::lower_bound(energy_, share * energy_.back()) - energy_.begin();
    return static_cast<double>(bin) * bin_hz_;
  }

  std::vector<double> energy_;  ///< up to each bin
  double bin_hz_ = 0.0;
};

/// A profile, and the limits that it gives a drive.
struct DriveProfile {
  ActuatorProfile figures;
  DriveLimits limits;
};

/// What goes to one drive of a scene.
struct Drive {
  std::string name;
  std::vector<double> samples;
  Spectrum spectrum;
  std::vector<DriveProfile> profiles;  ///< that the scene names for it

  Interval band() const { return spectrum.band(); }
  /// [N] The largest force on the case of an actuator whose mass this drive moves, mass x'', with
  ///   X / Y(jw) = metres_at_full_scale / (1 - (w/w0)^2 + j w / (w0 Q))
  /// the model of the excursion limiter: without inductance, load or stops.
  double force_on_case(const ExcursionLimits& model, double mass, double rate_hz) const;
};

/// What a scene needs.
struct Demand {
  std::string scene;
  double rate_hz = 0.0;
  std::vector<Drive> drives;
  // Nothing: no port measures it, of travel no sensor either.
  std::optional<double> force, torque;  ///< [N], [N m] the largest on the player
  std::optional<double> travel, angle;  ///< [m], [rad] to either side
  std::optional<double>
      case_force;       ///< [N] where nothing is measured or sensed: of the scene's own actuators
  bool senses = false;  ///< an input of the instrument comes from the plant
  std::optional<Stability>
      stability;                    ///< with the plant of the scene; nothing: the instrument senses nothing
  std::vector<std::string> plants;  ///< files of the other parts

  bool turns = false;  ///< what moves in the scene moves in rad
  bool rotates() const { return ((torque || angle) && !force && !travel) || turns; }
  bool moves_straight() const { return (force || travel) && !torque && !angle; }
  /// A force must be there at rest.
  bool holds_force() const { return force || torque || senses; }
};

/// Plays the scene that a command line names. Throws a CommandError, also where it drives no actuator.
Demand demand_of(const std::string& text);

}  // namespace tactus::app
