#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/graph/node_type.h"
#include "engine/plot/plot.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus {

/// How the networks of a plant are stepped.
struct SolverVariant {
  std::string solver;
  int oversample = 1;  ///< 0: as the file says
  Hertz rate;
};
/// [any] "exact x 4 at 48 kHz"
std::string to_string(const SolverVariant& variant);

/// What to try; empty lists: all solvers, the scene's rate with its half and its double, 1 to 16 steps a
/// frame. A part of several measures no times: they are comparable only where one process takes all of them.
struct WorkPrecisionOptions : RunPlan {
  std::vector<std::string> solvers = {};
  std::vector<Hertz> rates = {};
  std::vector<int> oversamples = {};
  int repeats = 5;  ///< runs for the time, of which the median counts
};

/// One variant: what it costs and how wrong it is.
struct WorkPoint {
  SolverVariant variant;
  std::optional<Error> refused;  ///< the network cannot be stepped so
  bool unstable = false;         ///< non-finite or exploding values: no errors are given
  std::vector<double> errors;    ///< relative, in the order of the scene's [accuracy]; empty: none
  std::vector<double> floors;    ///< what the reference may be off itself at this rate, likewise
  std::vector<bool> front;       ///< nothing cheaper is closer, likewise
  double ns_per_frame = 0;

  bool known() const { return !errors.empty(); }
  /// The reference is ten times closer than this.
  bool trusted(std::size_t accuracy) const { return errors[accuracy] >= 10 * floors[accuracy]; }
  /// Computing for a second of the scene. [s]
  double load() const { return 1e-9 * ns_per_frame * variant.rate.value; }
};

/// What the errors of one line of [accuracy] are measured against, and how far that may be off itself.
struct ReferenceUsed {
  std::string accuracy, measure, of;
  std::string what;      ///< "closed form"
  double own_error = 0;  ///< relative: the largest, over the rates, between two references
};

struct WorkPrecision {
  std::string scene;
  std::vector<ReferenceUsed> references;  ///< in the order of [accuracy]
  std::vector<WorkPoint> points;
  /// Variants and repeats; `points` is empty until all variants are finished.
  std::ptrdiff_t runs = 0, finished = 0;

  /// The cheapest variant within real time whose errors are all at most `error`; nullptr if there is none.
  const WorkPoint* cheapest(double error) const;
};

/// [control] A sweep over rate, solver and oversampling that measures errors and times. Every run is compared
/// with a reference at its own rate, which has the same inputs from frame to frame: so the error is that of
/// the solver. References: what theory says (`exact`); else the reference solution (Solver::Reference) with
/// one and with three steps a frame, whose difference is its own error. Workers share the runs for the
/// errors; times are measured one after another. Errors: those of the scene; Missing without [accuracy] or a
/// network; BadFile of the cache.
Checked<WorkPrecision> study_work_precision(const SceneSpec& scene, const NodeTable& table,
                                            const WorkPrecisionOptions& options = {});

/// [control] The same for the scene as it is written: one run, whose variant names no solver. Errors: those
/// of the scene; Missing without [accuracy].
Checked<WorkPrecision> evaluate_as_written(const SceneSpec& scene, const NodeTable& table);

/// [any] Error against computing time, a plot for each line of [accuracy]: a curve for each solver and rate
/// over its oversampling, the Pareto front, and the limit of real time.
std::vector<Plot> plots_of(const WorkPrecision& study);

}  // namespace tactus
