#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "engine/graph/file/error_list.h"
#include "engine/graph/plan/compile.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {
namespace {

struct Edge {
  int to;
  bool late;
};

bool is_late(const Vertex& vertex, std::size_t input) {
  return vertex.kind == Vertex::Kind::Node && vertex.type->inputs[input].late;
}

/// Guaranteed from late inputs to outputs, in engine frames: any run of d R of them holds d frames of a part
/// at a rate of 1/R, wherever it begins.
int least_delay(const Vertex& vertex) {
  if (vertex.kind != Vertex::Kind::Node) return 0;
  int least = std::numeric_limits<int>::max();
  // A node that could not be made is taken to delay as much as any, so that it seems to close no loop.
  for (std::size_t i = 0; i < vertex.in.size() && vertex.node != nullptr; ++i)
    for (int output = 0; is_late(vertex, i) && output < vertex.outputs; ++output)
      least = std::min(least, vertex.node->delay(static_cast<int>(i), output).least);
  if (least == std::numeric_limits<int>::max()) return kMaxSubBlock;
  return std::min(least, std::numeric_limits<int>::max() / vertex.divisor) * vertex.divisor;
}

class Ordering {
 public:
  Ordering(const VertexGraph& graph, bool closed_outside)
      : graph_(graph), size_(static_cast<int>(graph.vertices.size()) + (closed_outside ? 1 : 0)) {
    readers_.resize(index(size_));
    for (const auto& vertex : graph.vertices) least_.push_back(least_delay(vertex));
    least_.resize(index(size_), 0);
    const int outside = closed_outside ? size_ - 1 : -1;
    for (int v = 0; v < static_cast<int>(graph.vertices.size()); ++v) {
      const auto& vertex = vertex_at(v);
      for (std::size_t i = 0; i < vertex.in.size(); ++i)
        readers_[index(vertex.in[i].vertex)].push_back({v, is_late(vertex, i)});
      if (outside < 0) continue;
      // A tap only listens: nothing outside answers it.
      if (vertex.kind == Vertex::Kind::Output && graph.channels[index(vertex.index)].use != OutputUse::Tap)
        readers_[index(v)].push_back({outside, false});
      if (vertex.kind == Vertex::Kind::Input) readers_[index(outside)].push_back({v, false});
    }
  }

  Checked<std::vector<OrderedSection>> run() {
    if (auto errors = cycle_errors(); !errors.empty()) return tl::unexpected(std::move(errors));
    auto components = find_components(kUncut);
    std::vector<OrderedSection> sections;
    // What is read comes last.
    for (auto it = components.rbegin(); it != components.rend(); ++it) {
      if (is_cycle(*it, kUncut)) {
        sections.push_back(order_loop(*it));
      } else {
        if (sections.empty() || sections.back().loop) sections.emplace_back();
        sections.back().vertices.push_back({step_of_whole(it->front()), it->front()});
      }
    }
    return sections;
  }

 private:
  const Vertex& vertex_at(int v) const { return graph_.vertices[index(v)]; }
  bool is_outside(int v) const { return v >= static_cast<int>(graph_.vertices.size()); }
  StepKind step_of_whole(int v) const { return is_outside(v) ? StepKind::Outside : StepKind::Process; }
  const std::vector<Edge>& readers(int v) const { return readers_[index(v)]; }

  /// A sub-block that no delay cuts.
  static constexpr int kUncut = std::numeric_limits<int>::max();

  bool cuts(const Edge& edge, int sub_block) const {
    return edge.late && least_[index(edge.to)] >= sub_block;
  }

  /// Whether a component is more than one vertex that does not read itself.
  bool is_cycle(const std::vector<int>& component, int sub_block) const {
    const int v = component.front();
    return component.size() > 1 || std::ranges::any_of(readers(v), [&](const Edge& edge) {
             return edge.to == v && !cuts(edge, sub_block);
           });
  }

  /// Over the edges that `sub_block` does not cut.
  std::vector<std::vector<int>> find_components(int sub_block) const {
    std::vector<std::vector<int>> next(readers_.size());
    for (std::size_t v = 0; v < readers_.size(); ++v)
      for (const auto& edge : readers_[v])
        if (!cuts(edge, sub_block)) next[v].push_back(edge.to);
    return strong_components(next, Roots::LastToFirst);
  }

  /// Every cycle in `component` is cut by a delay of a frame or more.
  OrderedSection order_loop(std::vector<int>& component) const {
    std::sort(component.begin(), component.end());
    const std::set<int> inside(component.begin(), component.end());
    std::set<int, std::greater<>> delays;  // a longer sub-block first
    for (const int v : component)
      for (const auto& edge : readers(v))
        if (edge.late && inside.contains(edge.to))
          delays.insert(std::min(kMaxSubBlock, least_[index(edge.to)]));
    for (const int sub_block : delays)
      if (auto section = try_order(component, inside, sub_block)) return *section;
    return {};
  }

  /// Kahn's algorithm without the edges that `sub_block` cuts. nullopt: there is still a cycle.
  std::optional<OrderedSection> try_order(const std::vector<int>& component, const std::set<int>& inside,
                                          int sub_block) const {
    OrderedSection section;
    section.loop = true;
    section.sub_block = sub_block;
    section.delay_frames = std::numeric_limits<int>::max();
    std::map<int, int> waiting;
    std::set<int> split;
    for (const int v : component)
      for (const auto& edge : readers(v)) {
        if (!inside.contains(edge.to)) continue;
        if (cuts(edge, sub_block)) {
          split.insert(edge.to);
          section.delay_frames = std::min(section.delay_frames, least_[index(edge.to)]);
        } else
          ++waiting[edge.to];
      }
    std::vector<int> ready;
    for (auto it = component.rbegin(); it != component.rend(); ++it)
      if (waiting[*it] == 0) ready.push_back(*it);
    while (!ready.empty()) {
      const int v = ready.back();
      ready.pop_back();
      section.vertices.push_back({split.contains(v) ? StepKind::Emit : step_of_whole(v), v});
      for (const auto& edge : readers(v))
        if (inside.contains(edge.to) && !cuts(edge, sub_block) && --waiting[edge.to] == 0)
          ready.push_back(edge.to);
    }
    if (section.vertices.size() < component.size()) return std::nullopt;
    for (const int v : split) section.vertices.push_back({StepKind::Absorb, v});
    return section;
  }

  /// One for each part of the graph in which signals go round within a frame.
  std::vector<Error> cycle_errors() const {
    std::vector<Error> errors;
    for (const auto& component : find_components(1))
      if (is_cycle(component, 1)) errors.push_back(cycle_error({component.begin(), component.end()}));
    sort_by_place(errors);
    return errors;
  }

  Error cycle_error(const std::set<int>& stuck) const {
    const auto cycle = walk_cycle(stuck);
    std::vector<std::string> names;
    Source at;
    for (const int v : cycle) {
      if (is_outside(v)) continue;
      const auto& vertex = vertex_at(v);
      if (at.line == 0) at = vertex.at;
      if (names.empty() || names.back() != vertex.path)
        names.push_back(vertex.path);  // operators of one expression
    }
    while (names.size() > 1 && names.back() == names.front()) names.pop_back();
    std::string loop;
    for (const auto& name : names) loop += name + " -> ";
    return {Errc::Cycle, at.text(), loop + names.front() + " contains no delay", remedy(cycle)};
  }

  std::string remedy(const std::vector<int>& cycle) const {
    if (std::any_of(cycle.begin(), cycle.end(), [this](int v) { return is_outside(v); }))
      return "a sensor responds to its drive in the same frame: give the scene a delay of at least one frame";
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      const int next = cycle[(i + 1) % cycle.size()];
      for (const auto& edge : readers(cycle[i]))
        if (edge.to == next && edge.late)
          return "'" + vertex_at(next).path +
                 "' can be shorter than one frame: keep its time at one frame or more, with 'min' if "
                 "necessary";
    }
    return "insert a 'delay' node in one of these connections";
  }

  /// A cycle in `stuck`, from its first vertex on. Everything stuck waits for something stuck, so that
  /// walking backwards never ends before a vertex comes up again.
  std::vector<int> walk_cycle(const std::set<int>& stuck) const {
    std::map<int, int> waits_for;
    for (const int v : stuck)
      for (const auto& edge : readers(v))
        if (stuck.contains(edge.to) && !cuts(edge, 1)) waits_for.emplace(edge.to, v);
    std::vector<int> path;
    std::set<int> seen;
    int v = *stuck.begin();
    for (; seen.insert(v).second; v = waits_for.at(v)) path.push_back(v);
    path.erase(path.begin(), std::find(path.begin(), path.end(), v));
    std::reverse(path.begin(), path.end());
    std::rotate(path.begin(), std::min_element(path.begin(), path.end()), path.end());
    return path;
  }

  const VertexGraph& graph_;
  std::vector<int> least_;
  int size_;
  std::vector<std::vector<Edge>> readers_;
};

}  // namespace

Checked<std::vector<OrderedSection>> order(const VertexGraph& graph, bool closed_outside) {
  return Ordering{graph, closed_outside}.run();
}

}  // namespace tactus
