#include <algorithm>

#include "engine/core/index.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {
namespace {

using Edges = std::vector<std::vector<int>>;

/// [vertex] what reads it.
Edges readers_in(const VertexGraph& graph) {
  Edges readers(graph.vertices.size());
  for (int v = 0; v < static_cast<int>(graph.vertices.size()); ++v) {
    const auto& vertex = graph.vertices[index(v)];
    for (const auto& wire : vertex.in) readers[index(wire.vertex)].push_back(v);
  }
  return readers;
}

/// The masses and springs of a network act on each other; only declarations of networks have a fingerprint.
bool is_network(const Vertex& vertex) { return vertex.type != nullptr && vertex.type->fingerprint != 0; }

std::vector<int> loop_vertices(const VertexGraph& graph, const Edges& readers) {
  std::vector<int> found;
  for (const auto& component : strong_components(readers, Roots::FirstToLast)) {
    const int v = component.front();
    const auto& next = readers[index(v)];
    if (component.size() > 1 || std::ranges::find(next, v) != next.end() ||
        is_network(graph.vertices[index(v)]))
      found.push_back(v);
  }
  return found;
}

/// [vertex] whether a path leads to it.
std::vector<bool> reached(std::vector<int> from, const Edges& readers) {
  std::vector<bool> seen(readers.size(), false);
  while (!from.empty()) {
    const int v = from.back();
    from.pop_back();
    if (seen[index(v)]) continue;
    seen[index(v)] = true;
    from.insert(from.end(), readers[index(v)].begin(), readers[index(v)].end());
  }
  return seen;
}

}  // namespace

void find_feedback_paths(VertexGraph& graph) {
  const auto readers = readers_in(graph);
  std::vector<int> inputs;
  for (int v = 0; v < static_cast<int>(graph.vertices.size()); ++v)
    if (graph.vertices[index(v)].kind == Vertex::Kind::Input) inputs.push_back(v);
  const auto from_input = reached(std::move(inputs), readers);
  const auto from_loop = reached(loop_vertices(graph, readers), readers);
  for (int v = 0; v < static_cast<int>(graph.vertices.size()); ++v) {
    const auto& vertex = graph.vertices[index(v)];
    if (vertex.kind != Vertex::Kind::Output) continue;
    auto& channel = graph.channels[index(vertex.index)];
    channel.from_input = from_input[index(v)];
    channel.from_loop = from_loop[index(v)];
  }
}

}  // namespace tactus
