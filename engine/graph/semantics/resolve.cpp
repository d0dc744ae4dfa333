#include "engine/graph/semantics/resolve.h"

#include "engine/graph/semantics/instance.h"

namespace tactus {

Resolved resolve(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate,
                 const std::vector<std::string>& taps, std::size_t most_signals) {
  Resolved resolved;
  resolved.graph.signals.emplace_back().kind = FlatSignal::Kind::Missing;
  Mistakes mistakes;
  Resolving resolving{table, sample_rate, resolved.graph, mistakes, most_signals};
  Instance top{spec, resolving, "", 1};
  top.declare_top();
  top.connect_top(taps);
  resolved.too_large = resolving.too_large;
  resolved.mistakes = mistakes.take();
  return resolved;
}

}  // namespace tactus
