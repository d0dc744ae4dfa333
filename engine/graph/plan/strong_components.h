#pragma once

// Thread: [any].

#include <vector>

namespace tactus {

enum class Roots { FirstToLast, LastToFirst };

/// [any] The strongly connected components of a directed graph, each behind all that it reaches. `next[v]`:
/// the vertices that v leads to; `roots`: in which order the search begins at vertices not seen yet. Not
/// recursive: a graph may be a chain of 100,000 vertices. Source: Tarjan, SIAM J. Comput. 1(2), 1972.
std::vector<std::vector<int>> strong_components(const std::vector<std::vector<int>>& next, Roots roots);

}  // namespace tactus
