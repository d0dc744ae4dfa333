#pragma once

// Thread: [control].

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/build_scene.h"
#include "engine/scene/closed_loop.h"
#include "engine/study/stability/models/stability_graph.h"
#include "engine/study/stability/stability_plan.h"

namespace tactus {

/// What an instrument that is looked at without a scene is taken to move: a mass on a damper, pushed by its
/// forces and telling its position and speed,
///     m x'' = F - b x'.
struct AssumedDevice {
  double mass = 0.050;   ///< [kg]
  double damping = 0.1;  ///< [N s/m]
};

/// A graph with its loops closed over the outside.
struct ClosedGraph {
  LinearGraph graph;
  std::vector<int> drives;  ///< signals between the instrument's outputs and what delays them
  std::vector<std::string> drive_names;
  /// From a force on what is driven to its position, at any z; empty where nothing is.
  std::function<std::complex<double>(std::complex<double>)> mobility;
};

/// An input and an output of an instrument between which nothing is known of the outside.
struct OpenPair {
  std::string input, output;
  int from = -1, to = -1;  ///< in the graph
};

/// What is to be analysed, and how.
struct WorldOptions {
  std::optional<Hertz> rate;
  Seconds delay = 0_s;
  std::map<std::string, ControlValue> set;
  AssumedDevice device;
  bool friction = true;  ///< false: of a scene's networks nothing rubs
};

/// A scene, or an instrument alone: one of the two.
struct StabilitySubject {
  const LoadedScene* scene = nullptr;
  const LoadedGraph* instrument = nullptr;
  const NodeTable* table = nullptr;
};

/// [control] Both engines of a scene; for an instrument alone, the second one is the assumed device.
Checked<BuiltScene> build_world(const StabilitySubject& subject, const WorldOptions& options, bool vectorise);

/// An instrument in its world that has run for a moment on silence and unheard, so that every signal stands
/// where it rests: what the instrument does to the world is what is to be judged, and might explode.
class RestingWorld {
 public:
  static Checked<RestingWorld> make(const StabilitySubject& subject, const WorldOptions& options);

  /// [control]
  ClosedGraph closed(const Regime& regime) const;
  /// Of an instrument alone: the inputs and drives that the device does not join.
  std::vector<OpenPair> open_pairs(LinearGraph& graph, const Regime& regime) const;
  /// The ways that its contacts and laws can be in: at rest, touched, each contact closed.
  std::vector<Regime> regimes(double push) const;

  /// Whether something is known of what lies between outputs and inputs.
  bool outside_known() const;

  Hertz rate() const { return instrument().sample_rate; }
  int delay_frames() const { return built_.delay_frames; }
  const Plan& instrument() const { return built_.instrument->plan(); }

 private:
  explicit RestingWorld(BuiltScene built) : built_(std::move(built)) {}
  void rest();
  void join_plant(ClosedGraph& closed, const Regime& regime, const Terminals& instrument) const;

  BuiltScene built_;
  bool alone_ = false;
};

}  // namespace tactus
