#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/scene/measures/playability_result.h"
#include "engine/study/sweep/sweep.h"

namespace tactus {

/// One run and its result.
struct PlayedRun : EvaluatedPoint<PlayabilityResult> {
  double delay_s = 0;
};

/// All runs at one delay.
struct DelayVerdict {
  double delay_s = 0;
  double score = 0;        ///< mean over the runs as written
  bool playable = false;   ///< all runs as written are, and `robust` is at least kRobustShare
  int runs = 0, good = 0;  ///< as written; and those of them that are playable
  int varied = 0, varied_good = 0;
  std::size_t worst = 0;  ///< the run as written with the lowest score

  double robust() const { return varied == 0 ? 1.0 : static_cast<double>(varied_good) / varied; }
};

/// Of the other actuators and plants so many must be playable too.
inline constexpr double kRobustShare = 0.9;

struct PlayabilityStudy {
  std::string scene;
  Playability::Kind kind = Playability::Kind::Roll;
  std::vector<double> delays_s;
  std::vector<SweptValue> over;  ///< besides the delay
  std::vector<std::string> variants;
  std::vector<PlayedRun> runs;  ///< delay by delay, then value by value, then variant by variant

  /// [any] Index of the kind of a finished run in `run_kinds`.
  std::size_t kind_of(const PlayedRun& run) const;
  /// [any] Of a complete study, delay by delay.
  std::vector<DelayVerdict> verdicts() const;
  /// How many runs there are at one delay.
  std::size_t runs_a_delay() const { return runs.size() / delays_s.size(); }
};

/// [any] A complete study as a page of plots. Nothing swept besides the delay: score, kind and the main
/// measures, over the delay. One quantity: maps of kind, score and the main measure over delay and quantity.
/// Two: a map of the kind over both, for up to twelve delays.
std::vector<Plot> plots_of(const PlayabilityStudy& study);

/// [control] A sweep in which each run is scored; the first quantity is the delay, and at most two follow.
/// Errors: those of the scene; Missing without [playability]; BadFile of the cache.
Checked<PlayabilityStudy> study_playability(const SceneSpec& scene, const NodeTable& table,
                                            const SweepPlan& plan);

}  // namespace tactus
