#pragma once

// Thread: [control].

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "engine/scene/build_scene.h"
#include "engine/scene/closed_loop.h"
#include "engine/study/stability/models/stability_graph.h"

namespace tactus {

/// The device of an instrument without a scene: a mass on a damper, driven by its forces, whose position and
/// velocity are its sensors,
///     m x'' = F - b x'.
struct AssumedDevice {
  double mass = 0.050;   ///< [kg]
  double damping = 0.1;  ///< [N s/m]
};

/// A graph with its loops closed over the outside.
struct ClosedGraph {
  LinearGraph graph;
  std::vector<int> drives;  ///< signals between the instrument's outputs and what delays them
  /// From a force on the driven point to its position, at any z; empty if no point is driven.
  std::function<std::complex<double>(std::complex<double>)> mobility;
};

/// An input and an output of an instrument between which the path outside is not known. With a gain outside
/// below 1 / peak it is stable at any delay.
struct OpenPair {
  std::string input, output;
  int from = -1, to = -1;        ///< in the graph
  double peak = 0, peak_hz = 0;  ///< the largest gain of the instrument
};

/// Conditions of the analysis; of an instrument alone 48 kHz without delay, unless given.
struct WorldOptions : SceneOptions {
  AssumedDevice device = {};
  /// Of outputs of an instrument alone: the cut-off frequency of the card's AC coupling, a one-pole high-pass
  /// between the output and the device.
  std::map<std::string, Hertz> output_highpass = {};
  bool friction = true;  ///< false: the networks of the scene have no friction
  bool gestures = true;  ///< false: those of the scene stay where they begin
};

/// A scene, or an instrument alone: one of the two.
struct StabilitySubject {
  const LoadedScene* scene = nullptr;
  const LoadedGraph* instrument = nullptr;
  const NodeTable* table = nullptr;
};

/// [control] Both engines of a scene; for an instrument alone, the second one is the assumed device.
Checked<BuiltScene> build_world(const StabilitySubject& subject, const WorldOptions& options);

/// What is added to an input of the instrument while its world settles.
struct HeldInput {
  int channel = 0;
  double level = 0;         ///< SI
  bool alternates = false;  ///< every 2 ms; else a constant
};

/// An instrument in its world that has run for a moment on silence with its drives disconnected (the closed
/// loop might be unstable), so that every signal has its resting value.
class RestingWorld {
 public:
  static Checked<RestingWorld> make(const StabilitySubject& subject, const WorldOptions& options,
                                    const std::vector<HeldInput>& held = {});

  /// [control]
  ClosedGraph closed(const Regime& regime) const;
  /// Of an instrument alone: the inputs and drives that the device does not join.
  std::vector<OpenPair> open_pairs(LinearGraph& graph, const Regime& regime) const;
  /// Input channels of the instrument that something else may move than its gestures: those that its drives
  /// reach, and all of an instrument alone.
  std::vector<int> moved_inputs() const;
  /// Where an input of the instrument rests [SI], before something is added to it.
  double resting(int channel) const { return resting_[static_cast<std::size_t>(channel)]; }
  /// "m", "rad": of an input that reads a length or an angle; "" of others, and of an instrument alone.
  std::string unit_of_place(int channel) const;
  /// Its operating points: at rest, touched, each contact closed.
  std::vector<Regime> regimes(double push) const;

  /// Whether the path from outputs to inputs is known.
  bool outside_known() const;

  Hertz rate() const { return instrument().sample_rate; }
  int delay_frames() const { return built_.delay_frames; }
  const Plan& instrument() const { return built_.instrument->plan(); }

 private:
  explicit RestingWorld(BuiltScene built) : built_(std::move(built)) {}
  void rest(const std::vector<HeldInput>& held);
  /// All loops, and the nonlinearities on them: others make no operating points.
  LinearGraph with_laws_of_loops() const;
  void join_plant(ClosedGraph& closed, const Regime& regime, const Terminals& instrument) const;

  BuiltScene built_;
  SamplingClocks clocks_;
  std::vector<double> resting_;
  bool moving_ = false;  ///< something moves it before it comes to rest
  bool alone_ = false;
};

/// [control] From where to where each input of the instrument goes while the scene is played, behind the
/// guard and for 8 s at most; SI. Nothing for an instrument alone.
std::vector<Interval> played_ranges(const StabilitySubject& subject, const WorldOptions& options);

}  // namespace tactus
