#include "engine/graph/plan/unfolded_nodes.h"

namespace tactus {
namespace {

/// Of one lane of an expression; a list has one entry for each lane.
std::size_t size_of(const Term& term) {
  if (term.op == Term::Op::Lanes || term.op == Term::Op::Spread) return 1;
  std::size_t size = 1;
  for (const auto& argument : term.arguments) size += size_of(argument);
  return size;
}

std::size_t in_lanes(std::size_t size, int lanes) { return size * static_cast<std::size_t>(lanes); }

}  // namespace

std::size_t unfolded_nodes(const FlatGraph& graph) {
  std::size_t count = 0;
  for (const auto& signal : graph.signals)
    count +=
        in_lanes(signal.kind == FlatSignal::Kind::Expression ? 1 + size_of(signal.term) : 1, signal.lanes);
  for (const auto& node : graph.nodes) {
    std::size_t inputs = 1 + node.inputs.size() * (1 + node.compensate.size());
    for (const auto& input : node.inputs)
      if (input) inputs += size_of(*input);
    count += in_lanes(inputs, node.lanes);
  }
  for (const auto& output : graph.outputs) count += in_lanes(1 + size_of(output.term), output.lanes);
  return count;
}

}  // namespace tactus
