#include "engine/graph/plan/vertex_graph.h"

namespace tactus {

std::string Vertex::description() const {
  switch (kind) {
    case Kind::Node:
      return type->name;
    case Kind::PhaseDelay:
      return "phase delay";
    case Kind::Sum:
      return "sum of lanes";
    case Kind::Pack:
      return "pack";
    case Kind::RateConverter:
      return divisor > conversion.from ? "to 1/" + std::to_string(divisor)
                                       : "from 1/" + std::to_string(conversion.from);
    default:
      return "1 operation";
  }
}

void VertexGraph::compact() {
  std::vector<bool> read(vertices.size(), false);
  for (const auto& vertex : vertices) {
    if (!vertex.alive) continue;
    for (const auto& wire : vertex.in) read[index(wire.vertex)] = true;
    if (vertex.kind == Vertex::Kind::PhaseDelay && vertex.index >= 0) read[index(vertex.index)] = true;
  }
  std::vector<int> place(vertices.size(), -1);
  std::vector<Vertex> kept;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    if (!vertices[v].alive || (vertices[v].kind == Vertex::Kind::Constant && !read[v])) continue;
    place[v] = static_cast<int>(kept.size());
    kept.push_back(std::move(vertices[v]));
  }
  for (auto& vertex : kept) {
    for (auto& wire : vertex.in) wire.vertex = place[index(wire.vertex)];
    if (vertex.kind == Vertex::Kind::PhaseDelay && vertex.index >= 0)
      vertex.index = place[index(vertex.index)];
  }
  vertices = std::move(kept);
}

}  // namespace tactus
