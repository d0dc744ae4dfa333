#include <algorithm>
#include <cstddef>

#include "engine/core/index.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {
namespace {

class Search {
 public:
  explicit Search(const std::vector<std::vector<int>>& next)
      : next_(next), number_(next.size(), -1), low_(next.size()), edge_(next.size(), 0), open_(next.size()) {}

  std::vector<std::vector<int>> run(Roots roots) {
    const int count = static_cast<int>(next_.size());
    for (int i = 0; i < count; ++i)
      if (const int root = roots == Roots::FirstToLast ? i : count - 1 - i; number_[at(root)] < 0)
        visit(root);
    return std::move(components_);
  }

 private:
  static std::size_t at(int v) { return index(v); }

  void enter(int v) {
    number_[at(v)] = low_[at(v)] = counter_++;
    stack_.push_back(v);
    open_[at(v)] = true;
    path_.push_back(v);
  }

  void visit(int root) {
    enter(root);
    while (!path_.empty()) {
      const int v = path_.back();
      if (edge_[at(v)] < next_[at(v)].size()) {
        const int to = next_[at(v)][edge_[at(v)]++];
        if (number_[at(to)] < 0)
          enter(to);
        else if (open_[at(to)])
          low_[at(v)] = std::min(low_[at(v)], number_[at(to)]);
        continue;
      }
      path_.pop_back();
      if (!path_.empty()) low_[at(path_.back())] = std::min(low_[at(path_.back())], low_[at(v)]);
      if (low_[at(v)] == number_[at(v)]) leave(v);
    }
  }

  void leave(int v) {
    auto& component = components_.emplace_back();
    int last = -1;
    do {
      last = stack_.back();
      stack_.pop_back();
      open_[at(last)] = false;
      component.push_back(last);
    } while (last != v);
  }

  const std::vector<std::vector<int>>& next_;
  std::vector<int> number_, low_, stack_, path_;
  std::vector<std::size_t> edge_;
  std::vector<bool> open_;  ///< on the stack
  std::vector<std::vector<int>> components_;
  int counter_ = 0;
};

}  // namespace

std::vector<std::vector<int>> strong_components(const std::vector<std::vector<int>>& next, Roots roots) {
  return Search{next}.run(roots);
}

}  // namespace tactus
