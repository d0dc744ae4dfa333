#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/graph/flat_graph.h"

namespace tactus {

/// Output `port` of vertex `vertex`.
struct Wire {
  int vertex = -1;
  int port = 0;
  bool operator==(const Wire&) const = default;
};

/// The graph with every lane on its own: what is pruned, folded and scheduled.
struct Vertex {
  enum class Kind { Constant, Input, Control, SystemDelay, Operation, Node, PhaseDelay, Output };

  Kind kind = Kind::Constant;
  Term::Op op = Term::Op::Number;  ///< Operation; `Signal` copies
  double value = 0;                ///< Constant
  int index = -1;                  ///< of the channel, control, output channel, or flat node
  int lane = 0;
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

/// Unfolds the lanes: one vertex for each lane of each node, one for each operator of each expression.
VertexGraph lower(const FlatGraph& flat);

/// Takes out what reaches no output and works out what never changes. `flat` tells which nodes may be
/// evaluated.
void simplify(VertexGraph& graph, const FlatGraph& flat, Hertz sample_rate);

}  // namespace tactus
