#pragma once

#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/node_table.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// How the networks of a plant are stepped.
struct SolverVariant {
  std::string solver;
  int oversample = 1;  ///< 0: as the file says
  Hertz rate;
};

/// "exact x 4 at 48 kHz"
std::string to_string(const SolverVariant& variant);

/// [control] The scene with every network of every part but the instrument, parts of parts too, stepped so.
SceneSpec with_solver(SceneSpec scene, const SolverVariant& variant);

/// [control] The words of `solver` that step a network: all that it takes, but the one that chooses among
/// them and the one that they are measured against.
std::vector<std::string> stepping_solvers();
/// [control] Networks of these parts have links that are all linear: nothing touches, slides or lets go.
bool is_linear(const SceneSpec& scene);
/// [control] There is a network at all.
bool has_network(const SceneSpec& scene);

}  // namespace tactus
