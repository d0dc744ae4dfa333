#pragma once

// Thread: [control].

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/study/stability/stability.h"

namespace tactus {

/// A disturbance of the instrument's sensors, added to the signals of the plant.
struct Disturbance {
  const char* name;
  /// At a frame and its time [s]; `period`: of what comes every 37 ms, in frames.
  double (*at)(std::int64_t frame, double seconds, std::int64_t period);
};
/// Silence is the first.
extern const std::array<Disturbance, 5> kDisturbances;

/// A run to execute.
struct ExtremePlan {
  std::string what = {};
  WorldOptions world = {};
  const Disturbance* disturbance = &kDisturbances.front();
  double seconds = 0.5;
  double drive_gain = 1;     ///< on every drive
  bool linear = false;       ///< one push at the start, no guard, no converters: to see which side it is on
  double push_s = 0;         ///< of linear runs: how long the push lasts, a frame at least
  double growing_hz = 0;     ///< of linear runs: of the root that is predicted to grow; 0: none is
  bool expected = true;      ///< false: predicted to grow
  std::string control = {};  ///< which one is at the end of its range
  bool elsewhere = false;    ///< at another rate, delay or control than requested
};

/// [full scale] An output that comes to more, and to `kGrown` times what it was in the first 37 ms, has
/// exploded: a loop grows. An instrument of a large gain is beyond the first alone.
constexpr double kExploded = 1e6;
constexpr double kGrown = 1e3;

/// One run of the engine and its result. Of a linear run before and after are not energies, but the largest
/// change of a sensor in the second and the last quarter; of one that is predicted to grow, its part at the
/// growing root.
struct ExtremeRun : ExtremePlan {
  Hertz rate = {};
  double delay_s = 0;
  double peak = 0;           ///< of the drives, behind the guard where there is one
  bool faded = false;        ///< the guard faded a drive for feedback
  double energy_before = 0;  ///< of the networks, largest in the first three quarters [J]
  double energy_after = 0;   ///< and in the last
  std::int64_t faults = 0;   ///< of nodes
  bool finite = true;
  bool grew = false;
  bool exploded = false;  ///< an output of the instrument did, ahead of its guard
  bool bounded() const { return finite && faults == 0 && !grew && !exploded; }
  /// A run that is predicted to grow may fault, or be limited by the guard and by nonlinearities.
  bool as_expected() const { return finite && (expected ? bounded() : grew || !linear); }
};

/// [control] Extreme conditions: rates, delays, controls at both ends, disturbances.
std::vector<ExtremePlan> extremes_of(const WorldOptions& world, const Plan& instrument);
/// [control] 2 % below and above the border of the loop at rest that one drive closes, long enough for the
/// root to grow or decay; none if no such loop can grow, if it only creeps away, or with nonlinearities or
/// events in it.
std::vector<ExtremePlan> border_runs(const WorldOptions& world, const StabilityVerdict& verdict);
/// [any] The same world before gestures begin: they leave the controls alone.
WorldOptions without_gestures(WorldOptions world, const StabilityVerdict& verdict);
/// [control] Errors: of the graph at that rate, with those controls.
Checked<ExtremeRun> run_extreme(const StabilitySubject& subject, const ExtremePlan& plan);
/// [any] Energy that the gestures supply is no growth: a run did not grow if it ends with at most four times
/// the energy of the undisturbed run, unless that grew.
void exclude_player_energy(std::vector<ExtremeRun>& runs);

}  // namespace tactus
