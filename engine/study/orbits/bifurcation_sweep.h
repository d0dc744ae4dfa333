#pragma once

#include <vector>

#include "engine/study/orbits/bifurcation.h"

namespace tactus {

/// What a ball did while a control was held.
struct HeldValue {
  double value = 0;
  std::vector<Landing> landings;  ///< times since the scene began
};
using SweepResult = Result<std::vector<HeldValue>>;

/// A scene whose control is moved by a gesture of its own.
class SceneSweep {
 public:
  /// [control] Errors: as `study_bifurcation`.
  static Checked<SceneSweep> make(const SceneSpec& scene, const NodeTable& table,
                                  const BifurcationPlan& plan);

  /// [control] Plays the scene: the control glides to the first of these values and is held at each. Does not
  /// change this, so that several may run at once.
  SweepResult run(const std::vector<double>& values) const;

  double frequency() const { return frequency_; }
  /// The control is the acceleration of the table.
  bool of_the_table() const { return of_the_table_; }

 private:
  SceneSweep(const SceneSpec& scene, const NodeTable& table, const BifurcationPlan& plan)
      : scene_(scene), table_(&table), plan_(plan) {}
  Status find_control();

  SceneSpec scene_;
  const NodeTable* table_;
  BifurcationPlan plan_;
  double frequency_ = 0;
  bool of_the_table_ = false;
};

}  // namespace tactus
