#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/node_type.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {

/// Doubles on cache-line boundaries, so that vector loads of whole groups never straddle two lines.
class Arena {
 public:
  void resize(std::size_t doubles);
  double* data() const { return base_; }
  std::size_t size() const { return size_; }

 private:
  std::unique_ptr<double[]> storage_;
  double* base_ = nullptr;
  std::size_t size_ = 0;
};

/// The places that read a signal which may rest: their stride is 0 while it does, else 1.
struct Readers {
  std::vector<int> slots;     ///< in Schedule::inputs
  std::vector<int> channels;  ///< in Schedule::channels
};

/// One element-wise operation over the frames of a piece; operands are slots of the step.
struct MicroOperation {
  Term::Op op;
  int first_in = 0;  ///< in Schedule::inputs
  double* out = nullptr;
  int path = 0;       ///< in Schedule::paths
  int can_rest = -1;  ///< in Schedule::can_rest, or -1
};

/// One entry of the flat list that a block runs through.
struct Step {
  enum class Kind : std::uint8_t {
    Process,     ///< node->process
    Emit,        ///< first half of a node that closes a loop
    Absorb,      ///< its second half
    Operations,  ///< adjacent element-wise operations, one call
    Outside,  ///< the place where what lies outside answers (a plant whose drive depends on its own sensors)
  };
  Kind kind = Kind::Process;
  int node = -1;
  int first_in = 0, inputs = 0;    ///< in Schedule::inputs
  int first_out = 0, outputs = 0;  ///< in Schedule::outputs
  int first_operation = 0, operations = 0;
  int width = 1;  ///< numbers a frame of every output
  /// Of the frames that it runs in, and of what it reads and gives (which differ at the border of a part with
  /// a rate of its own): in Schedule::paces.
  int pace = 0, pace_in = 0, pace_out = 0;
  bool can_fail = true;  ///< may give what is not finite although all that it reads is
  int path = 0;          ///< in Schedule::paths
};

/// Steps that run together, `sub_block` frames at a time. A section that is a loop is reset as a whole when
/// one of its steps gives something that is not finite.
struct Section {
  int first_step = 0;
  int end_step = 0;
  int sub_block = kMaxPiece;
  bool loop = false;
};

struct ScheduledControl {
  FlatControl control;
  double* buffer = nullptr;  ///< samples while it ramps; kWide times the same while it rests
  Readers readers;
  bool frozen = false;  ///< some node needed its value when it was made: it cannot change while running
};

struct ScheduledChannel {
  std::string name;
  OutputUse use = OutputUse::Drive;
  Dimension dimension;
  Signal signal;
};

/// What `tactus explain` tells about a loop.
struct LoopReport {
  std::vector<std::string> paths;
  int sub_block = 0;
  int delay_frames = 0;  ///< least delay once around, over the edges that were cut
};

/// A graph ready to run: a flat list of steps over one arena, and everything it points to.
struct Schedule {
  std::string name;
  Hertz sample_rate = 48_kHz;
  std::vector<std::shared_ptr<Node>> nodes;
  std::vector<std::uint64_t> fingerprints;             ///< of `nodes` (see fingerprint.h)
  std::vector<std::shared_ptr<const NodeType>> types;  ///< of `nodes`; keeps network declarations alive
  std::vector<std::string> whats;                      ///< of `nodes`: "low_pass", "phase delay", "pack"
  std::vector<Step> steps;
  std::vector<Section> sections;
  std::vector<int> paces = {1};  ///< engine frames between two of a part's own; the first is the engine's
  std::vector<Signal> inputs;
  std::vector<double*> outputs;
  std::vector<MicroOperation> operations;
  /// Of operations on nothing but controls and numbers: while those rest each is one number, which rests too.
  std::vector<Readers> can_rest;
  std::vector<std::string> paths;

  std::vector<std::string> input_names;
  std::vector<double*> input_buffers;  ///< nullptr: nobody reads the channel
  std::vector<ScheduledControl> controls;
  double* system_delay = nullptr;  ///< kWide times the same, in seconds, or nullptr if nobody reads it
  Seconds system_delay_at_start;
  std::vector<ScheduledChannel> channels;

  Arena arena;
  std::vector<std::unique_ptr<double>> constants;
  std::vector<std::unique_ptr<std::array<double, kWide>>> wide_constants;

  std::vector<LeftOut> left_out;
  std::vector<LoopReport> loops;

  /// Index in `controls`, or -1.
  int control_index(std::string_view control) const;
};

}  // namespace tactus
