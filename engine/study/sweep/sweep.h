#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/node_type.h"
#include "engine/plot/plot.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/play_scene.h"
#include "engine/study/sweep/evaluate_runs.h"

// Thread: [control]

namespace tactus {

/// A quantity of a scene that is varied: a control of the instrument ("strength") or of another part
/// ("plant.grip"); a gesture, whose values are scaled, or which is held at one value; a constant of a network
/// or a node ("plant.drum.coil.resistance"); the system delay, the sample rate, the solver or its
/// oversampling.
struct SweptValue {
  enum class What {
    Control,
    Scaled,  ///< a gesture; the values are factors
    Held,    ///< a gesture; they have its unit
    Constant,
    Delay,
    Rate,
    Solver,
    Oversample,
  };
  std::string name;
  std::vector<ControlValue> values;  ///< SI, or factors
  What what = What::Control;
  std::vector<std::string> names = {};  ///< of solvers; the values are their indices
};
/// The quantity of this name. Errors: UnknownName with the nearest name; UnitMismatch; OutOfRange.
Result<SweptValue> find_swept(const SceneSpec& scene, const std::string& name,
                              std::vector<ControlValue> values);
/// The solvers of these names. Errors, at `option`: UnknownName.
Result<SweptValue> swept_solvers(const std::vector<std::string>& names, const char* option = "--over");

/// All combinations of some values, each with several actuators and plants.
struct SweepPlan : RunPlan {
  std::vector<SweptValue> over;             ///< the last one varies fastest
  std::map<std::string, ControlValue> set;  ///< as SceneOptions::set, in every run
  std::vector<double> gains;                ///< other strengths of the actuator, besides 1
  int draws = 0;                            ///< other samples of the plant
  double within = 0.2;                      ///< how far their quantities are from the file's
  std::uint64_t seed = 1;                   ///< of the draws
};

inline constexpr auto kAsWritten = "as written";

/// One run of a sweep, and what it gave.
template <class Evaluated>
struct EvaluatedPoint {
  std::vector<double> at = {};           ///< one for each swept quantity, SI
  std::string variant = {};              ///< "as written", "actuator x 2", "draw 17"
  std::optional<Evaluated> result = {};  ///< nullopt: not played

  bool as_written() const { return variant == kAsWritten; }
};
using SweepPoint = EvaluatedPoint<RunResult>;

/// Plays a scene at every point of a plan.
class Sweep {
 public:
  /// The three must outlive this.
  Sweep(const SceneSpec& scene, const NodeTable& table, const SweepPlan& plan);

  /// A point as a scene.
  struct Run {
    std::vector<double> at;  ///< as of its point
    SceneSpec scene;
    SceneOptions options = {};
    std::size_t number = 0;
  };
  Run run_of(std::size_t number) const;
  /// An actuator and a plant.
  struct Variant {
    std::string name;
    double gain = 1;
    int draw = 0;  ///< from 1; 0: as written
  };
  /// The first is "as written".
  const std::vector<Variant>& variants() const { return variants_; }

  /// Compiles the scene at every single value and with every variant. Errors: those of the scene; BadArgument
  /// of a control that a gesture moves; UnitMismatch of a held gesture.
  Checked<void> check() const;

  using Evaluate = std::function<Checked<RunResult>(const Run&)>;
  /// Results of all points by `evaluate_runs`. `key` names what is evaluated; cached runs of another key do
  /// not count.
  Checked<std::vector<SweepPoint>> evaluate(const Evaluate& evaluate, const std::string& key);

 private:
  const SceneSpec& scene_;
  const NodeTable& table_;
  const SweepPlan& plan_;
  std::vector<Variant> variants_;
  std::vector<SweepPoint> points_;
};

/// Identifies a run of the study `what` in a cache.
std::uint64_t run_key(const std::string& what, const Sweep::Run& run);

/// What is measured, as a part of what identifies a run.
std::string measure_key(const MeasureEntry& measure);

/// How many points have a result.
std::ptrdiff_t finished(const auto& points) {
  return std::ranges::count_if(points, [](const auto& point) { return point.result.has_value(); });
}

/// Builds and plays the scene of a run.
Checked<SceneRecording> play_run(const Sweep::Run& run, const NodeTable& table);

/// "rate", "rms:instrument.sound": a line of [expect], or a measure and the signal that it is taken of, with
/// the text as its name. Errors: UnknownName.
Result<Expectation> find_swept_measure(const SceneSpec& scene, const std::string& text);

/// Measures over a plan.
struct SweepTable {
  std::string scene;
  std::vector<SweptValue> over;
  std::vector<Expectation> measures;
  std::vector<std::string> variants;
  std::vector<SweepPoint> points;
};
Checked<SweepTable> sweep_measures(const SceneSpec& scene, const NodeTable& table, const SweepPlan& plan,
                                   const std::vector<Expectation>& measures);

/// That of the measure; empty if it is the unit of the signal.
std::string unit_of(const Expectation& measure);
/// A value of a swept quantity with its unit: "1.2 m", "x 0.5", "passive".
std::string value_text(const SweptValue& swept, double si);
/// All of them.
std::vector<std::string> value_texts(const SweptValue& swept);
/// The values of a point: "strength 0.2, weight x 0.5".
std::string setting_text(const std::vector<SweptValue>& over, const std::vector<double>& at);

/// [any] A complete sweep as plots. One swept quantity: a line per measure. Two: a map per measure, the first
/// across; each combination of further ones has plots of its own, twelve at most. With draws: their measures
/// as points beside the scene as written.
std::vector<Plot> plots_of(const SweepTable& table);

}  // namespace tactus
