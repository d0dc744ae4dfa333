#include "engine/physics/solvers/elimination_order.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <tuple>

#include "engine/core/index.h"

namespace tactus {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Nodes = std::vector<int>;

// Parts of so many unknowns are not divided any more: four registers of eight.
constexpr std::size_t kSmallestPart = 32;

// Each side of a separator has at least this share of the unknowns.
constexpr double kSmallestShare = 1.0 / 8.0;

/// Which unknowns share an equation.
class Graph {
 public:
  explicit Graph(const Sparse& matrix) : starts_(index(matrix.rows()) + 1) {
    each_link(matrix, [&](int one, int other) { ++starts_[index(one) + 1], ++starts_[index(other) + 1]; });
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    neighbours_.resize(index(starts_.back()));
    auto free = starts_;
    each_link(matrix, [&](int one, int other) {
      neighbours_[index(free[index(one)]++)] = other;
      neighbours_[index(free[index(other)]++)] = one;
    });
  }

  int size() const { return static_cast<int>(starts_.size()) - 1; }
  template <class Visit>
  void each_neighbour(int node, Visit visit) const {
    for (int i = starts_[index(node)]; i < starts_[index(node) + 1]; ++i) visit(neighbours_[index(i)]);
  }

 private:
  template <class Visit>
  static void each_link(const Sparse& matrix, Visit visit) {
    for (int column = 0; column < matrix.outerSize(); ++column)
      for (Sparse::InnerIterator entry(matrix, column); entry; ++entry)
        if (entry.row() > column && entry.value() != 0.0) visit(static_cast<int>(entry.row()), column);
  }

  Nodes starts_, neighbours_;
};

class Dissection {
 public:
  Dissection(const Graph& graph, const std::vector<int>& minimum_degree)
      : graph_(graph), rank_(index(graph.size())), part_(rank_.size()), visit_(rank_.size()) {
    for (auto& list : distance_) list.resize(rank_.size());
    for (std::size_t i = 0; i < rank_.size(); ++i) rank_[index(minimum_degree[i])] = static_cast<int>(i);
  }

  std::vector<int> order() {
    Nodes all(rank_.size());
    std::iota(all.begin(), all.end(), 0);
    dissect(all);
    return std::move(order_);
  }

 private:
  struct Cut {
    Nodes left, separator, right;
  };
  using Coordinate = std::array<int, 2>;  // difference of the distances from two landmarks

  void enter(const Nodes& nodes) {
    ++parts_;
    for (const int node : nodes) part_[index(node)] = parts_;
  }

  void dissect(const Nodes& nodes) {
    enter(nodes);
    const int part = parts_;
    for (const int node : nodes)
      if (part_[index(node)] == part) divide(reached(node, 0));
  }

  /// A connected part.
  void divide(const Nodes& nodes) {
    enter(nodes);
    find_landmarks(nodes.front());
    if (nodes.size() <= kSmallestPart) return append_along(nodes);
    const auto cut = best_cut(nodes);
    if (!cut) return append_by(nodes, [&](int node) { return rank_[index(node)]; });
    for (const int node : cut->separator) part_[index(node)] = 0;
    dissect(cut->left);
    dissect(cut->right);
    append_by(cut->separator, [&](int node) { return distance_[2][index(node)]; });
  }

  /// All of its part that a node is connected with, nearest first; their distances to landmark `which`.
  Nodes reached(int start, std::size_t which) {
    ++visits_;
    Nodes nodes{start};
    auto& distance = distance_[which];
    const int part = part_[index(start)];
    visit_[index(start)] = visits_;
    distance[index(start)] = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      graph_.each_neighbour(nodes[i], [&](int next) {
        if (part_[index(next)] != part || visit_[index(next)] == visits_) return;
        visit_[index(next)] = visits_;
        distance[index(next)] = distance[index(nodes[i])] + 1;
        nodes.push_back(next);
      });
    return nodes;
  }

  /// 0 and 1: two ends of the part, in a rectangle opposite corners. 2: farthest from an end of the line that
  /// is as far from the one as from the other, in a rectangle a third corner.
  void find_landmarks(int any) {
    const int end = reached(any, 0).back();
    const int opposite = reached(end, 0).back();
    Nodes middle;
    for (const int node : reached(opposite, 1))
      if (std::abs(at(node, {0, 1})) <= 1) middle.push_back(node);
    reached(middle.front(), 2);
    const auto nearer = [&](int one, int other) {
      return distance_[2][index(one)] < distance_[2][index(other)];
    };
    const int side = *std::max_element(middle.begin(), middle.end(), nearer);
    reached(reached(side, 2).back(), 2);
  }

  int at(int node, const Coordinate& c) const {
    return distance_[index(c[0])][index(node)] - distance_[index(c[1])][index(node)];
  }

  std::optional<Cut> best_cut(const Nodes& nodes) const {
    std::optional<Cut> best;
    double best_score = 0.0;
    const auto offer = [&](Cut cut) {
      const auto left = static_cast<double>(cut.left.size()), right = static_cast<double>(cut.right.size());
      if (std::min(left, right) < kSmallestShare * static_cast<double>(nodes.size())) return;
      const double score = static_cast<double>(cut.separator.size()) * (1.0 / left + 1.0 / right);
      if (!best || score < best_score) best = std::move(cut), best_score = score;
    };
    for (const auto& coordinate : {Coordinate{2, 0}, Coordinate{2, 1}, Coordinate{0, 1}}) {
      const int middle = median(nodes, coordinate);
      const auto below = [&](int node) { return at(node, coordinate) < middle; };
      const auto above = [&](int node) { return at(node, coordinate) > middle; };
      offer(divided(nodes, below));
      offer(divided(nodes, above));
    }
    return best;
  }

  int median(const Nodes& nodes, const Coordinate& coordinate) const {
    Nodes values(nodes.size());
    std::transform(nodes.begin(), nodes.end(), values.begin(),
                   [&](int node) { return at(node, coordinate); });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }

  /// The separator: those outside `left` that are next to it.
  template <class Left>
  Cut divided(const Nodes& nodes, Left left) const {
    Cut cut;
    for (const int node : nodes) {
      bool touches = false;
      const bool inside = left(node);
      if (!inside)
        graph_.each_neighbour(node, [&](int next) {
          touches = touches || (part_[index(next)] == part_[index(node)] && left(next));
        });
      (inside ? cut.left : touches ? cut.separator : cut.right).push_back(node);
    }
    return cut;
  }

  template <class Key>
  void append_by(Nodes nodes, Key key) {
    std::sort(nodes.begin(), nodes.end(),
              [&](int a, int b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
    order_.insert(order_.end(), nodes.begin(), nodes.end());
  }

  void append_along(const Nodes& nodes) {
    const auto extent = [&](const Coordinate& c) {
      const auto [least, most] =
          std::minmax_element(nodes.begin(), nodes.end(), [&](int a, int b) { return at(a, c) < at(b, c); });
      return at(*most, c) - at(*least, c);
    };
    const Coordinate one{2, 0}, other{2, 1};
    const auto along = extent(one) > extent(other) ? one : other;
    append_by(nodes, [&](int node) { return std::tuple(at(node, along), distance_[2][index(node)]); });
  }

  const Graph& graph_;
  Nodes rank_, part_, visit_, order_;
  std::array<Nodes, 3> distance_;
  int parts_ = 0, visits_ = 0;
};

}  // namespace

std::vector<int> minimum_degree_order(const Sparse& matrix) {
  const Sparse lower = matrix.triangularView<Eigen::Lower>();
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>{}(lower.selfadjointView<Eigen::Lower>(), order);
  return {order.indices().begin(), order.indices().end()};
}

std::vector<int> nested_dissection_order(const Sparse& matrix, const std::vector<int>& minimum_degree) {
  const Graph graph(matrix);
  return Dissection(graph, minimum_degree).order();
}

std::size_t factor_entries(const Sparse& matrix, const std::vector<int>& order) {
  const Graph graph(matrix);
  const auto n = index(graph.size());
  std::vector<int> place(n), parent(n, -1), visited(n, -1);
  for (std::size_t i = 0; i < n; ++i) place[index(order[i])] = static_cast<int>(i);
  std::size_t entries = 0;
  for (int row = 0; row < graph.size(); ++row) {
    visited[index(row)] = row;
    graph.each_neighbour(order[index(row)], [&](int neighbour) {
      // Up the elimination tree: all columns that have a number in this row.
      for (int i = place[index(neighbour)]; i < row && visited[index(i)] != row; i = parent[index(i)]) {
        if (parent[index(i)] < 0) parent[index(i)] = row;
        visited[index(i)] = row;
        ++entries;
      }
    });
  }
  return entries;
}

}  // namespace tactus
