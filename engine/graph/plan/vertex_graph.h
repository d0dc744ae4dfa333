#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// Output `port` of vertex `vertex`; of a wide vertex one lane, or all of them for a wide reader.
struct Wire {
  static constexpr int kAllLanes = -1;
  int vertex = -1;
  int port = 0;
  int lane = 0;
  bool operator==(const Wire&) const = default;
};

/// What of the file a vertex is a lane of: the node or the operator, and which of several that this makes.
struct Origin {
  const void* of = nullptr;  ///< nullptr: it has no other lanes
  int nth = 0;
  explicit operator bool() const { return of != nullptr; }
  auto operator<=>(const Origin&) const = default;
};

/// The graph with every lane on its own: what is pruned, folded and scheduled. `widen` then puts lanes side
/// by side again.
struct Vertex {
  enum class Kind {
    Constant,
    Input,
    Control,
    SystemDelay,
    Operation,
    Node,
    PhaseDelay,
    Sum,       ///< all lanes of a signal; where nothing is wide, `widen` makes additions of it
    Pack,      ///< kWide signals put side by side
    Crossing,  ///< into a part with a rate of its own, or out of it
    Output
  };

  Kind kind = Kind::Constant;
  Term::Op op = Term::Op::Number;  ///< Operation; `Signal` copies
  double value = 0;                ///< Constant; PhaseDelay: its sign
  std::vector<double> values;      ///< Constant of width kWide
  int index = -1;                  ///< of the channel, control, output channel, or flat node
  int lane = 0;                    ///< the first one of a wide vertex
  int lanes = 1;                   ///< of its origin
  Origin origin;
  int width = 1;            ///< 1 or kWide
  int every = 1;            ///< engine frames between two of its samples
  SignalCrossing crossing;  ///< Crossing
  std::vector<Wire> in;
  int outputs = 1;
  std::string path;
  Source at;
  bool alive = true;
};

struct OutputChannel {
  std::string name;
  OutputUse use = OutputUse::Drive;
  Dimension dimension;
};

/// Something of the file that does not run, and why.
struct LeftOut {
  std::string path;
  std::string reason;
};

struct VertexGraph {
  std::vector<Vertex> vertices;
  std::vector<OutputChannel> outputs;
  std::vector<std::string> inputs;  ///< names of the channels
  std::vector<LeftOut> left_out;
};

/// Unfolds the lanes: one vertex for each lane of each node, one for each operator of each expression. What
/// is the same in all lanes is there once.
VertexGraph lower(const FlatGraph& flat);

/// Takes out what reaches no output and works out what never changes. `flat` tells which nodes may be
/// evaluated.
void simplify(VertexGraph& graph, const FlatGraph& flat, Hertz sample_rate);

}  // namespace tactus
