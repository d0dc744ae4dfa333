#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/semantics/flat_graph.h"

// Thread: [control].

namespace tactus {

/// Output `port` of vertex `vertex`; of a vectorised vertex one lane, or all of them for a vectorised reader.
struct Wire {
  static constexpr int kAllLanes = -1;
  int vertex = -1;
  int port = 0;
  int lane = 0;
  auto operator<=>(const Wire&) const = default;
};

/// What of the file a vertex is a lane of: the node or the operator, and which of several that this makes.
struct Origin {
  int of = -1;  ///< -1: it has no other lanes
  int nth = 0;
  explicit operator bool() const { return of >= 0; }
  auto operator<=>(const Origin&) const = default;
};

/// One vertex of the graph. `lower` makes one for every lane; `vectorise` then replaces eight lanes by one.
struct Vertex {
  enum class Kind {
    Constant,
    Input,
    Control,
    SystemDelay,
    Operation,
    Node,
    PhaseDelay,
    Sum,            ///< all lanes of a signal; where no lane is vectorised, additions replace it
    Pack,           ///< kVectorWidth scalar signals as one vectorised signal
    RateConverter,  ///< into a part with a rate of its own, or out of it
    Output
  };

  Kind kind = Kind::Constant;
  Expression::Op op = Expression::Op::Number;  ///< Operation; `Signal` copies
  double value = 0;                            ///< Constant; PhaseDelay: its sign
  std::vector<double> values = {};             ///< Constant of width kVectorWidth
  int index = -1;                              ///< of the channel, control, output channel, or flat node
  int lane = 0;                                ///< the first one of a vectorised vertex
  int lanes = 1;                               ///< of its origin
  Origin origin = {};
  int width = 1;                   ///< 1 or kVectorWidth
  int divisor = 1;                 ///< engine frames between two of its samples
  RateConversion conversion = {};  ///< RateConverter
  std::vector<Wire> in = {};
  int outputs = 1;
  std::string path = {};
  Source at = {};
  bool alive = true;
  std::vector<std::string> also = {};  ///< paths of equal nodes that it runs for

  std::shared_ptr<const NodeType> type = {};  ///< Node; keeps network declarations alive
  bool turns = false;                         ///< Node: see `turns`
  std::shared_ptr<Node> node = {};            ///< what runs it, until the plan takes it over (Plan::nodes)
  std::uint64_t fingerprint = 0;              ///< of all that `node` was made from

  // Set when the plan is built.
  int runs = -1;      ///< its node in Plan::nodes, or -1
  int nth = 0;        ///< of several vertices with the same path that run
  int first_in = -1;  ///< its operands in Plan::inputs; of a node that runs in two halves, the first half's

  /// What it does, for reports: "low_pass", "sum of lanes", "1 operation".
  std::string description() const;
};

struct OutputChannel {
  std::string name;
  OutputUse use = OutputUse::Drive;
  Dimension dimension;
  // Set when the plan is built.
  Wire from{};
  Signal signal{};
  bool from_input = false;  ///< a path leads to it from an input of the graph
  bool from_loop = false;   ///< a loop of the graph reaches it, or a network, which is a loop in itself
};

struct VertexGraph {
  std::vector<Vertex> vertices;
  std::vector<std::string> input_names;
  std::vector<OutputChannel> channels;
  std::vector<LeftOut> left_out;

  /// Removes the vertices that are not alive, and constants that nothing reads.
  void compact();
};

/// Unfolds the lanes: one vertex for each lane of each node, one for each operator of each expression. What
/// is the same in all lanes is there once.
VertexGraph lower(const FlatGraph& flat);

/// Removes what reaches no output and evaluates what never changes. `flat` has the nodes that may be
/// evaluated.
void simplify(VertexGraph& graph, const FlatGraph& flat, Hertz sample_rate);

/// Nodes that are written more than once, with the same settings and inputs, run once: `also` has the paths
/// of the others. Not those with lanes, with randomness, or in loops.
void merge_equal(VertexGraph& graph, const FlatGraph& flat);

/// Lanes 8k … 8k+7 of the same node, or of the same operator of an expression, become one vectorised vertex
/// (see Node::vectorised), so that a recurrence runs across lanes instead of along time, where at least four
/// of them exist. It reads another vectorised vertex as it is, one scalar for all lanes, or a Pack of
/// scalars; scalar vertices read one lane. Only where nodes with a vectorised form and a state take part:
/// operators alone are as fast along time. False: there is nothing to vectorise, and `graph` is as it was.
///
/// Lanes that run together have one sub-block, the shortest of theirs, and are reset together after a fault.
bool vectorise(VertexGraph& graph, const FlatGraph& flat);

/// Turns each Sum that no node does into additions.
void expand_sums(VertexGraph& graph);

struct CompileOptions;
struct Plan;

/// Makes the node of every vertex that has one. Phase delays that never change become constants of `graph`.
/// Returns which controls are frozen: their value was needed to make a node. Nodes that cannot be made are
/// nullptr, with an error.
std::vector<bool> make_nodes(VertexGraph& graph, const FlatGraph& flat, const CompileOptions& options,
                             ErrorList& errors);

/// What a step of a block does.
enum class StepKind : std::uint8_t {
  Process,     ///< node->process
  Emit,        ///< first half of a node that closes a loop
  Absorb,      ///< its second half
  Operations,  ///< adjacent element-wise operations, one call
  Outside,     ///< the place where what lies outside answers (a plant whose drive depends on its own sensors)
};

/// One vertex at one place of the order: whole, or one half of it.
struct OrderedVertex {
  StepKind step = StepKind::Process;
  int vertex = -1;
};

/// Vertices that run together: a loop, or everything between two loops.
struct OrderedSection {
  std::vector<OrderedVertex> vertices;
  bool loop = false;
  int sub_block = kMaxSubBlock;  ///< the largest S for which delays of S frames and more cut every cycle
  int delay_frames = 0;          ///< the shortest of the delays that cut
};

/// Puts the vertices in an order in which everything runs after what it reads. Strongly connected parts
/// become loops with the largest possible sub-block. With `closed_outside`, a vertex that represents the
/// world outside is put between all outputs and all inputs. Errors: one Cycle for each part of the graph with
/// a loop without a delay, naming the loop edge by edge.
Checked<std::vector<OrderedSection>> order(const VertexGraph& graph, bool closed_outside);

/// Sets `from_input` and `from_loop` of every channel. A path goes through vertices of every kind, whatever
/// their parameters are: a gain that is 0 now may be raised by a control.
void find_feedback_paths(VertexGraph& graph);

/// Lays the ordered vertices out as a flat list of steps over one arena.
std::unique_ptr<Plan> build_plan(VertexGraph graph, const FlatGraph& flat,
                                 const std::vector<OrderedSection>& sections,
                                 const std::vector<bool>& frozen_controls, const CompileOptions& options);

}  // namespace tactus
