#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/node_table.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/measures/judged_run.h"

namespace tactus {

/// Something that is swept: a control of the instrument ("strength"), of another part ("plant.grip"), or a
/// gesture, whose values are all scaled, or which stays at one value.
struct SweptValue {
  enum class What {
    Control,
    Scaled,  ///< a gesture; the values are factors
    Held,    ///< a gesture; they have its unit
  };
  std::string name;
  std::vector<ControlValue> values;  ///< SI, or factors
  What what = What::Control;
};

struct PlayabilityOptions {
  std::vector<double> delays_s;
  std::vector<SweptValue> over;             ///< at most two
  std::map<std::string, ControlValue> set;  ///< as SceneOptions::set, in every run
  std::vector<double> gains;                ///< other strengths of the actuator, besides 1
  int draws = 0;                            ///< other samples of the plant
  double within = 0.2;                      ///< how far their quantities are from what is written
  std::uint64_t seed = 1;                   ///< of the draws
  int workers = 0;                          ///< threads; 0: one a core
  int part = 0, parts = 1;                  ///< runs whose number is `part` modulo `parts` are played
  std::filesystem::path keep = {};          ///< folder of finished runs; empty: none is kept
  std::function<void(double)> progress = {};
  std::function<bool()> stop = {};  ///< true: no further run is begun
};

/// One run: where it was played, and what came of it.
struct PlayedRun {
  double delay_s = 0;
  std::vector<double> at;  ///< one for each that is swept, SI
  std::string variant;     ///< "as written", "actuator x 2", "draw 17"
  std::optional<JudgedRun> judged;

  bool as_written() const { return variant == "as written"; }
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
  std::vector<SweptValue> over;
  std::vector<std::string> variants;
  std::vector<PlayedRun> runs;  ///< delay by delay, then value by value, then variant by variant

  int finished() const;
  bool complete() const { return finished() == static_cast<int>(runs.size()); }
  /// [any] Of a complete study, delay by delay.
  std::vector<DelayVerdict> verdicts() const;
  /// How many runs there are at one delay.
  std::size_t runs_a_delay() const { return runs.size() / delays_s.size(); }
};

/// [control] Plays the scene at every delay, for every value of what is swept, with every actuator and every
/// plant, and judges each run. The result does not depend on the number of workers, nor on how often the
/// study was interrupted. Errors: those of the scene; Missing without [playability]; UnknownName, OutOfRange
/// of what is swept; BadFile of the folder.
Checked<PlayabilityStudy> study_playability(const SceneSpec& scene, const NodeTable& table,
                                            const PlayabilityOptions& options);

}  // namespace tactus
