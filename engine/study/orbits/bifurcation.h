#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/node_type.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus {

/// A sweep of one control of a scene in which a ball bounces on a table, up on one branch: each value is
/// reached from the one before it, and held. The scene gives the positions of both the roles `ball` and
/// `table`, and the controls that move the table `table_frequency` and `table_acceleration`.
struct BifurcationPlan : RunPlan {
  std::string control = {};                ///< as `find_control` takes it; empty: the table's acceleration
  double from = 0, to = 0;                 ///< SI; from < to
  int values = 48;                         ///< both ends among them
  double settling_s = 1.5;                 ///< at each value, before anything is read
  double reading_s = 1.5;                  ///< at each value
  std::optional<double> restitution = {};  ///< of the exact map; nothing: as measured
};

/// What the ball does at one value of the control.
struct BifurcationColumn {
  double value = 0;
  std::vector<double> speeds;  ///< of its landings, towards the table [m/s]
  std::vector<double> phases;  ///< of the same, in periods of the drive [0, 1)
  int period = 0;              ///< of its landings, as period_of says
};

/// Where the orbit of `bounces` landings gives way to one of twice as many.
struct Doubling {
  int bounces = 1;
  std::optional<double> simulated;  ///< nothing: not seen in the sweep
  std::optional<double> swept;      ///< the same by the sweep of the exact map
  double exact = 0;
};

struct Bifurcation {
  std::string scene, control;
  double frequency_hz = 0;
  std::ptrdiff_t runs = 0, finished = 0;  ///< unless all runs are finished, all that follows is empty
  double restitution = 0;                 ///< of the exact map
  double measured_restitution = 0;        ///< median over the landings of columns with period 1
  std::vector<BifurcationColumn> simulated = {};
  /// The ideal ball of that restitution, bouncing on a table that no ball moves; only where the control is
  /// the table's acceleration.
  std::vector<BifurcationColumn> exact = {};
  std::vector<Doubling> doublings = {};
};

/// [control] Simulates the columns in runs of a fixed number, each after a glide from the first value, so
/// that the result is the same for any number of workers. Errors: those of the scene; UnknownName, Missing of
/// its controls and roles; BadFile of the cache.
Checked<Bifurcation> study_bifurcation(const SceneSpec& scene, const NodeTable& table,
                                       const BifurcationPlan& plan);

/// [any] Where the columns change from `bounces` landings to twice as many. Behind a doubling the square of
/// the split between landings that were alike grows on a straight line from 0; so where that line begins.
std::optional<double> doubling_in(const std::vector<BifurcationColumn>& columns, int bounces);

}  // namespace tactus
