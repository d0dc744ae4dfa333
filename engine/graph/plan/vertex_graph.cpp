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
  /// Everything that a vertex refers to.
  const auto for_each_source = [](Vertex& vertex, auto visit) {
    for (auto& wire : vertex.in) visit(wire.vertex);
    if (vertex.kind == Vertex::Kind::PhaseDelay && vertex.index >= 0) visit(vertex.index);
  };
  std::vector<bool> read(vertices.size(), false);
  for (auto& vertex : vertices)
    if (vertex.alive) for_each_source(vertex, [&](int v) { read[index(v)] = true; });
  std::vector<int> place(vertices.size(), -1);
  std::ptrdiff_t left = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    if (!vertices[v].alive || (vertices[v].kind == Vertex::Kind::Constant && !read[v])) continue;
    place[v] = static_cast<int>(left);
    if (index(left) != v) vertices[index(left)] = std::move(vertices[v]);
    ++left;
  }
  vertices.erase(vertices.begin() + left, vertices.end());
  for (auto& vertex : vertices) for_each_source(vertex, [&](int& v) { v = place[index(v)]; });
}

}  // namespace tactus
