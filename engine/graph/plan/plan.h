#pragma once

// Thread: [control]; what runs on the audio thread is Running.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/node_type.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {

/// Doubles on cache-line boundaries, so that vector loads of whole groups never straddle two lines.
class Arena {
 public:
  void resize(std::size_t doubles) { lines_.resize(((size_ = doubles) + kOfLine - 1) / kOfLine); }
  double* data() { return reinterpret_cast<double*>(lines_.data()); }
  std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t kOfLine = 8;
  struct alignas(kOfLine * sizeof(double)) Line {
    double values[kOfLine] = {};
  };
  std::vector<Line> lines_;
  std::size_t size_ = 0;
};

/// The places that read a signal which may rest: their stride is 0 while it does, else 1.
struct Readers {
  std::vector<int> slots;     ///< in Plan::inputs
  std::vector<int> channels;  ///< in Plan::channels
};

/// One element-wise operation over the frames of a sub-block.
struct MicroOperation {
  Expression::Op op;
  int first_in = 0;  ///< in Plan::inputs: kMostOperands, the first in place of those that it does not have
  const Signal* in = nullptr;  ///< there
  double* out = nullptr;
  double (*value)(double a, double b, double c) noexcept = nullptr;  ///< Operator::value
  int vertex = 0;
  int can_rest = -1;  ///< in Plan::can_rest, or -1
  int operands = 1;
  bool can_fail = true;  ///< its output can be non-finite although its operands are finite
};

/// One entry of the flat list that a block runs through.
struct Step {
  using Kind = StepKind;
  Node* runs = nullptr;          ///< `node`
  const Signal* in = nullptr;    ///< the first of `inputs`, at `first_in` of Plan::inputs
  double* const* out = nullptr;  ///< of `outputs`, at `first_out` of Plan::outputs
  int node = -1;
  int inputs = 0, outputs = 0;
  int width = 1;  ///< numbers a frame of every output
  Kind kind = Kind::Process;
  bool divided = false;    ///< it runs, reads or writes at another rate than the engine's
  bool with_care = false;  ///< it is divided, or Outside
  /// The first of `outputs`, up to the last that is read, if they can be non-finite although all inputs are
  /// finite; else 0.
  int can_fail = 0;
  int first_operation = 0, operations = 0;
  int first_in = 0, first_out = 0;
  /// Of the frames that it runs in, and of what it reads and gives (which differ at the border of a part with
  /// a rate of its own): in Plan::divisors.
  int divider = 0, divider_in = 0, divider_out = 0;
  int vertex = -1;  ///< of Operations the first; Outside: -1
};

/// Steps that run together, `sub_block` frames at a time. A section that is a loop is reset as a whole when
/// one of its steps gives something that is not finite.
struct Section {
  int first_step = 0;
  int end_step = 0;
  int sub_block = kMaxSubBlock;
  bool loop = false;
};

/// Where the samples of a channel go; no data: nothing reads them.
struct InputBuffer {
  double* data = nullptr;
  int stride = 1;  ///< kVectorWidth: it is a lane of one of Plan::input_lanes
};

/// Channels that are lanes of one signal, and that nothing else reads: they are loaded as such, without a
/// step.
struct InputLanes {
  std::array<int, kVectorWidth> channels{};
  double* to = nullptr;
};

struct PlannedControl {
  FlatControl control;
  double* buffer = nullptr;  ///< samples while it ramps; kVectorWidth times the same while it rests
  Readers readers;
  bool frozen = false;  ///< some node needed its value when it was made: it cannot change while running
};

/// A loop, for `tactus explain`.
struct LoopReport {
  std::vector<std::string> paths;
  int sub_block = 0;
  int delay_frames = 0;  ///< least delay once around, over the edges that were cut
};

/// A graph ready to run: the frozen graph, a flat list of steps that refer to its vertices, and one arena for
/// their signals and constants.
struct Plan : VertexGraph {
  std::string name;
  Hertz sample_rate = 48_kHz;
  std::vector<PlannedControl> controls;
  std::vector<LoopReport> loops;
  std::vector<Error> warnings;  ///< what is allowed and probably not meant, by place in the files

  // Its execution.
  /// What runs, with its state. A replacement swaps the nodes that continue with those of the plan before.
  std::vector<std::shared_ptr<Node>> nodes;
  std::vector<Step> steps;
  std::vector<Section> sections;
  std::vector<int> divisors = {1};  ///< engine frames for each of a part's own; the first is the engine's
  std::vector<Signal> inputs;
  std::vector<double*> outputs;
  std::vector<MicroOperation> operations;
  /// Of operations on nothing but controls and numbers: while those rest each is one number, which rests too.
  std::vector<Readers> can_rest;
  std::vector<InputBuffer> input_buffers;  ///< [channel]
  std::vector<InputLanes> input_lanes;
  /// kVectorWidth times the same, in seconds, or nullptr if nothing reads it.
  double* system_delay = nullptr;
  Seconds system_delay_at_start;
  Arena arena;                     ///< buffers of signals, then constants
  std::size_t signal_doubles = 0;  ///< of `arena`

  /// [realtime] Steps run the nodes that are in `nodes` now.
  void point_at_nodes() noexcept {
    for (auto& step : steps)
      if (step.node >= 0) step.runs = nodes[static_cast<std::size_t>(step.node)].get();
  }

  /// Index in `controls`, or -1.
  int control_index(std::string_view control) const;
  const Vertex& vertex_of(const Wire& wire) const { return vertices[index(wire.vertex)]; }
  /// The number at a wire that never changes (the same for all lanes), or nullopt.
  std::optional<double> constant(const Wire& wire) const;
};

}  // namespace tactus
