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
#include "engine/scene/network_report.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus {

/// How the networks of a plant are stepped.
struct SolverVariant {
  std::string solver;  ///< of a file, or a published method
  int oversample = 1;  ///< 0: as the file says, or as `auto` chooses
  Hertz rate;
};
/// [any] "exact x 4 at 48 kHz"
std::string to_string(const SolverVariant& variant);

/// What to try; empty lists: all solvers, `auto` and all published methods; the scene's rate with its half
/// and its double; 1 to 16 steps a frame. A part of several measures no times: they are comparable only where
/// one process takes all of them.
struct WorkPrecisionOptions : RunPlan {
  std::vector<std::string> solvers = {};
  std::vector<Hertz> rates = {};
  std::vector<int> oversamples = {};
  int repeats = 5;          ///< runs for the time, of which the median counts; 0: no times are taken
  double tolerance = 0.01;  ///< the asked error, relative
};
/// [any] All names for `solvers`.
std::vector<std::string> studied_solvers();

/// One variant: what it costs and how wrong it is.
struct WorkPoint {
  SolverVariant variant;
  std::optional<Error> refused;  ///< the network cannot be stepped so
  bool unstable = false;         ///< non-finite or exploding values: no errors are given
  std::vector<double> errors;    ///< relative, in the order of the study's references; empty: none
  std::vector<double> floors;    ///< what the reference may be off itself at this rate, likewise
  std::vector<bool> front;       ///< nothing cheaper is closer, likewise
  double ns_per_frame = 0;
  double multiplications = 0;           ///< a frame, of all networks: see NetworkSolver::cost
  std::vector<NetworkReport> networks;  ///< of `auto` and of the scene as it is written
  /// Of `auto`: multiplications of the cheapest solvers with 1 to 64 steps whose bounds reach the asked
  /// error; nothing: some network has none.
  std::optional<double> cheapest_bounded;

  bool known() const { return !errors.empty(); }
  double largest_error() const;
  /// The reference is ten times closer than this.
  bool trusted(std::size_t accuracy) const { return errors[accuracy] >= 10 * floors[accuracy]; }
  /// Computing for a second of the scene. [s]
  double load() const { return 1e-9 * ns_per_frame * variant.rate.value; }
  bool is_auto() const { return variant.solver == "auto"; }
  bool is_published() const;
  /// Of `networks`, the largest; nothing: one of them has none.
  std::optional<double> error_bound() const;
};

/// What `auto` chose at a rate, beside the cheapest variant whose measured errors are the asked one or less.
/// That may be cheaper than any whose bounds are: a scene need not excite every resonance.
struct AutoCost {
  const WorkPoint* chosen;
  const WorkPoint* cheapest;   ///< of the solvers; nullptr: none reaches it
  const WorkPoint* published;  ///< of the published methods; likewise

  /// Multiplications of the choice, as a multiple of those of `cheapest`.
  double operations() const { return chosen->multiplications / cheapest->multiplications; }
  double times() const { return chosen->ns_per_frame / cheapest->ns_per_frame; }
  /// The same of the cheapest one by bounds.
  std::optional<double> bounded_operations() const {
    if (!chosen->cheapest_bounded) return std::nullopt;
    return chosen->multiplications / *chosen->cheapest_bounded;
  }
};

/// What the errors of one line of [accuracy] are measured against, and how far that may be off itself.
struct ReferenceUsed {
  std::string accuracy, measure, of;
  std::string what;      ///< "closed form"
  double own_error = 0;  ///< relative: the largest, over the rates, between two references
};

struct WorkPrecision {
  std::string scene;
  Hertz rate;                             ///< of the scene
  double tolerance = 0.01;                ///< the asked error
  std::vector<ReferenceUsed> references;  ///< in the order of [accuracy]
  std::vector<WorkPoint> points;
  /// Variants and repeats; `points` is empty until all variants are finished.
  std::ptrdiff_t runs = 0, finished = 0;

  /// The cheapest variant within real time whose errors are all at most `error`; nullptr if there is none.
  const WorkPoint* cheapest(double error) const;
  /// For each rate at which `auto` was tried.
  std::vector<AutoCost> auto_costs() const;
};

/// [control] A sweep over rate, solver and oversampling that measures errors and times. Every run is compared
/// with a reference at its own rate, which has the same inputs from frame to frame: so the error is that of
/// the solver. References: what theory says (`exact`); else the reference solution (Solver::Reference) with
/// one and with three steps a frame, whose difference is its own error. Of a scene without [accuracy] the
/// paths of the positions that its parts with networks give are compared, or if there are none, of all their
/// outputs. Published methods take the place of a network's solver, with the same inputs. Workers share the
/// runs for the errors; times are measured one after another. Errors: those of the scene; Missing without a
/// network; BadFile of the cache.
Checked<WorkPrecision> study_work_precision(const SceneSpec& scene, const NodeTable& table,
                                            const WorkPrecisionOptions& options = {});

/// [control] The same for the scene as it is written: one run, whose variant names no solver.
Checked<WorkPrecision> evaluate_as_written(const SceneSpec& scene, const NodeTable& table);

/// [any] Error against computing time at the scene's rate (else the first that was tried), a plot for each
/// compared measure: a curve for each solver over its oversampling, those of published methods dashed, the
/// choice of `auto`, and the limit of real time.
std::vector<Plot> plots_of(const WorkPrecision& study);

}  // namespace tactus
