#include "engine/study/stability/models/stability_graph.h"

#include <cmath>

#include "engine/core/index.h"

namespace tactus {

int LinearGraph::add_signal(std::string name) {
  signals.push_back(std::move(name));
  return static_cast<int>(signals.size()) - 1;
}

void LinearGraph::delay(int from, int to, int frames) {
  edges.push_back({.kind = LinearEdge::Kind::Delay, .from = from, .to = to, .path = {}, .frames = frames});
}

void LinearGraph::gains(std::complex<double> z, const std::vector<std::size_t>& of,
                        std::vector<std::complex<double>>& gains) const {
  std::vector<Eigen::MatrixXcd> responses(networks.size());
  gains.resize(edges.size());
  for (const auto e : of) {
    const auto& edge = edges[e];
    switch (edge.kind) {
      case LinearEdge::Kind::Gain:
        gains[e] = edge.gain;
        break;
      case LinearEdge::Kind::Delay:
        gains[e] = std::exp(-static_cast<double>(edge.frames) * std::log(z));
        break;
      case LinearEdge::Kind::Node:
        gains[e] =
            edge.node->response(edge.input, edge.output, std::pow(z, edge.divisor), edge.at).value_or(0.0);
        break;
      case LinearEdge::Kind::Network: {
        auto& response = responses[index(edge.network)];
        if (response.size() == 0)
          response = networks[index(edge.network)]->response(std::pow(z, edge.divisor));
        gains[e] = response(edge.output, edge.input);
        break;
      }
      case LinearEdge::Kind::Event:
        gains[e] = 0.0;
        break;
    }
  }
}

}  // namespace tactus
