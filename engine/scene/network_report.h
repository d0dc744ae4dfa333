#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "engine/physics/solvers/solver_choice.h"
#include "engine/runtime/step_times.h"
#include "engine/scene/build_scene.h"

namespace tactus {

/// A network that runs: what steps it, how wrong that may be, and what it takes.
struct NetworkReport {
  std::string name;  ///< its path in the graph: "drum"
  std::string file;  ///< that it is written in
  Solver solver;
  int oversample = 1;
  std::optional<SolverBounds> bounds;  ///< nothing: it is the reference solution
  std::optional<double> ns_per_frame;  ///< nothing: it was not timed

  /// The bound on its error, relative: of resonances, decays and contacts, and of the forces of what slips;
  /// nothing: there is none.
  std::optional<double> error_bound() const;
};

/// In a run of so many frames, one block in how many is to be timed.
int timed_every(double frames);

/// The networks of a plan, in the order in which they run. `step_ns`: of each of its steps, per frame (see
/// StepTimes); empty: not timed.
std::vector<NetworkReport> report_networks(const Plan& plan, const std::vector<double>& step_ns);

/// The steps of both players of a scene, timed while it runs.
class SceneTimes {
 public:
  /// Some hundred blocks of a run of so many frames are timed, and few of a long one.
  SceneTimes(BuiltScene& built, double frames);
  /// [control & stopped] After each block.
  void add(int frames);
  /// Those of the plant, then those of the instrument.
  std::vector<NetworkReport> networks() const;

 private:
  BuiltScene& built_;
  StepTimes plant_, instrument_;
};

/// [any] "exact x2"
std::string describe_solver(const NetworkReport& network);
/// [any] "error at most 0.4 %", or why it is not bounded.
std::string describe_bound(const NetworkReport& network);
/// [any] "network 'violin' in plant.toml: exact x2, error at most 0.4 %, 310 ns per frame"
std::string describe(const NetworkReport& network);

}  // namespace tactus
