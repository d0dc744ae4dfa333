#include "engine/study/stability/stability_loops.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <set>

#include "engine/core/index.h"
#include "engine/core/units.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {
namespace {

std::complex<double> mean_of_frames(std::complex<double> z, int frames) {
  std::complex<double> sum = 0.0, power = 1.0;
  for (int i = 0; i < frames; ++i, power /= z) sum += power;
  return sum / static_cast<double>(frames);
}

/// The gains at z of the edges `of`.
void find_gains(const LinearGraph& graph, std::complex<double> z, const std::vector<std::size_t>& of,
                std::vector<std::complex<double>>& gains) {
  std::vector<Eigen::MatrixXcd> responses(graph.networks.size());
  gains.resize(graph.edges.size());
  const auto log_z = std::log(z);
  for (const auto e : of) {
    const auto& edge = graph.edges[e];
    const auto at = [&] { return edge.divisor == 1 ? z : std::pow(z, edge.divisor); };
    switch (edge.kind) {
      case LinearEdge::Kind::Gain:
      case LinearEdge::Kind::Delay:
        gains[e] = edge.gain;
        if (edge.frames > 0) gains[e] *= std::exp(-static_cast<double>(edge.frames) * log_z);
        break;
      case LinearEdge::Kind::Node:
        gains[e] = edge.constant ? *edge.constant
                                 : edge.node->response(edge.input, edge.output, at(), edge.at).value_or(0.0);
        break;
      case LinearEdge::Kind::Network: {
        const auto& network = graph.networks[index(edge.network)]->response();
        auto& all = responses[index(edge.network)];
        if (!network.by_modes() && all.size() == 0) all = network.at(at());
        gains[e] =
            network.by_modes() ? network.at(at(), edge.output, edge.input) : all(edge.output, edge.input);
        break;
      }
      case LinearEdge::Kind::Hold:
        gains[e] = mean_of_frames(z, edge.frames);
        break;
      case LinearEdge::Kind::Event:
        gains[e] = 0.0;
        break;
    }
  }
}

}  // namespace

std::vector<std::vector<int>> loops_of(const LinearGraph& graph, bool events) {
  std::vector<std::vector<int>> next(graph.signals.size());
  std::set<int> own_loop;
  for (const auto& edge : graph.edges) {
    if (edge.kind == LinearEdge::Kind::Event && !events) continue;
    next[index(edge.from)].push_back(edge.to);
    if (edge.from == edge.to) own_loop.insert(edge.from);
  }
  auto parts = strong_components(next, Roots::FirstToLast);
  std::erase_if(parts,
                [&](const auto& part) { return part.size() == 1 && !own_loop.contains(part.front()); });
  for (auto& part : parts) std::ranges::sort(part);
  return parts;
}

LoopGroup::LoopGroup(const LinearGraph& graph, std::vector<int> signals, const std::vector<int>& wanted)
    : graph_(&graph), signals_(std::move(signals)), place_(graph.signals.size(), -1) {
  for (std::size_t i = 0; i < signals_.size(); ++i) place_[index(signals_[i])] = static_cast<int>(i);
  incoming_.resize(signals_.size());
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const auto& edge = graph.edges[e];
    if (edge.kind == LinearEdge::Kind::Event || place_[index(edge.from)] < 0 || place_[index(edge.to)] < 0)
      continue;
    edges_.push_back(e);
    incoming_[index(place_[index(edge.to)])].push_back(e);
  }
  choose_cuts(wanted);
  if (!too_large()) put_in_order();
}

LoopGroup LoopGroup::sampled(const LinearGraph& graph, std::vector<int> signals, int frames) {
  std::vector<int> samples;
  for (const auto& edge : graph.edges)
    if (edge.kind != LinearEdge::Kind::Event && std::ranges::binary_search(signals, edge.from) &&
        std::ranges::binary_search(signals, edge.to) &&
        graph.divisors[static_cast<std::size_t>(edge.from)] <
            graph.divisors[static_cast<std::size_t>(edge.to)])
      samples.push_back(edge.to);
  LoopGroup group(graph, std::move(signals), samples);
  group.frames_ = frames;
  const auto slow = [&](int signal) { return graph.divisors[static_cast<std::size_t>(signal)] > 1; };
  std::ranges::copy_if(group.cuts_, std::back_inserter(group.inner_cuts_), std::not_fn(slow));
  std::erase_if(group.cuts_, std::not_fn(slow));
  if (!group.too_large()) group.put_in_order();
  return group;
}

int frames_between_samples(const LinearGraph& graph, const std::vector<int>& signals) {
  std::set<int> divisors;
  for (const int signal : signals) divisors.insert(graph.divisors[index(signal)]);
  if (divisors.size() == 1) return 1;
  return divisors.size() == 2 && *divisors.begin() == 1 ? *divisors.rbegin() : 0;
}

int LoopGroup::cut(int signal) const {
  const auto found = std::ranges::find(cuts_, signal);
  return found == cuts_.end() ? -1 : static_cast<int>(found - cuts_.begin());
}

/// The wanted ones; then, while loops are left, the signal with most ways in times ways out.
void LoopGroup::choose_cuts(const std::vector<int>& wanted) {
  std::set<int> left(signals_.begin(), signals_.end());
  const auto take = [&](int signal) {
    cuts_.push_back(signal);
    left.erase(signal);
  };
  for (const int signal : wanted)
    if (left.contains(signal)) take(signal);
  while (!too_large()) {
    std::map<int, int> in, out;
    for (const auto e : edges_) {
      const auto& edge = graph_->edges[e];
      if (left.contains(edge.from) && left.contains(edge.to)) ++out[edge.from], ++in[edge.to];
    }
    const auto ends = std::erase_if(left, [&](int s) { return in[s] == 0 || out[s] == 0; });
    if (left.empty()) return;
    if (ends > 0) continue;
    take(*std::ranges::max_element(left, [&](int a, int b) { return in[a] * out[a] < in[b] * out[b]; }));
  }
}

/// Without the cuts there is no loop: every component is one signal, behind all that it reads.
void LoopGroup::put_in_order() {
  order_.clear();
  const auto is_cut = [&](int signal) {
    return cut(signal) >= 0 || std::ranges::count(inner_cuts_, signal) > 0;
  };
  std::vector<std::vector<int>> reads(signals_.size());
  for (const auto e : edges_) {
    const auto& edge = graph_->edges[e];
    if (!is_cut(edge.from) && !is_cut(edge.to))
      reads[index(place_[index(edge.to)])].push_back(place_[index(edge.from)]);
  }
  for (const auto& component : strong_components(reads, Roots::FirstToLast))
    if (const int signal = signals_[index(component.front())]; !is_cut(signal)) order_.push_back(signal);
}

/// From samples to frames.
bool LoopGroup::holds(std::size_t edge) const {
  const auto& e = graph_->edges[edge];
  return graph_->divisors[index(e.from)] > graph_->divisors[index(e.to)];
}

Eigen::MatrixXcd LoopGroup::returned(std::complex<double> z) const {
  if (frames_ == 1) return returned_each_frame(z);
  const auto slow = static_cast<Eigen::Index>(cuts_.size()),
             fast = static_cast<Eigen::Index>(inner_cuts_.size());
  const auto root = std::exp(std::log(z) / static_cast<double>(frames_));
  held_only_ = true;
  const Eigen::MatrixXcd among_samples = returned_each_frame(root).topLeftCorner(slow, slow);
  held_only_ = false;
  Eigen::MatrixXcd folded = among_samples;
  for (int k = 0; k < frames_; ++k) {
    const auto all = returned_each_frame(root * std::polar(1.0, 2 * kPi * k / frames_));
    folded += all.topLeftCorner(slow, slow) - among_samples;
    if (fast == 0) continue;
    const Eigen::MatrixXcd one = Eigen::MatrixXcd::Identity(fast, fast);
    folded += all.topRightCorner(slow, fast) *
              Eigen::MatrixXcd(one - all.bottomRightCorner(fast, fast)).inverse() *
              all.bottomLeftCorner(fast, slow);
  }
  return folded;
}

const std::vector<std::complex<double>>& LoopGroup::gains_at(std::complex<double> z) const {
  gains_.assign(graph_->edges.size(), 0.0);
  find_gains(*graph_, z, edges_, gains_);
  return gains_;
}

/// Cuts that are sampled come first.
Eigen::MatrixXcd LoopGroup::returned_each_frame(std::complex<double> z) const {
  find_gains(*graph_, z, edges_, gains_);
  if (held_only_)
    for (const auto e : edges_)
      if (holds(e)) gains_[e] = 0.0;
  const std::size_t count = cuts_.size() + inner_cuts_.size();
  const auto cut_signal = [&](std::size_t c) {
    return c < cuts_.size() ? cuts_[c] : inner_cuts_[c - cuts_.size()];
  };
  const auto values_of = [&](int place) { return values_.data() + count * index(place); };
  values_.assign(count * signals_.size(), 0.0);
  for (std::size_t c = 0; c < count; ++c) values_of(place_[index(cut_signal(c))])[c] = 1.0;
  const auto add_incoming = [&](int place, std::complex<double>* to) {
    for (const auto e : incoming_[index(place)]) {
      const auto* from = values_of(place_[index(graph_->edges[e].from)]);
      for (std::size_t c = 0; c < count; ++c) to[c] += gains_[e] * from[c];
    }
  };
  for (const int s : order_) add_incoming(place_[index(s)], values_of(place_[index(s)]));
  const auto size = static_cast<Eigen::Index>(count);
  using ByRows = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  ByRows returned = ByRows::Zero(size, size);
  for (std::size_t c = 0; c < count; ++c)
    add_incoming(place_[index(cut_signal(c))], returned.data() + count * c);
  return returned;
}

std::complex<double> LoopGroup::characteristic(const Eigen::MatrixXcd& returned) {
  const auto one = Eigen::MatrixXcd::Identity(returned.rows(), returned.cols());
  return Eigen::MatrixXcd(one - returned).determinant();
}

LoopGroup::Loops LoopGroup::loops(const Eigen::MatrixXcd& returned) {
  if (returned.rows() == 1) return {characteristic(returned), {returned(0, 0)}};
  const auto one = Eigen::MatrixXcd::Identity(returned.rows(), returned.cols());
  const auto lu = Eigen::MatrixXcd(one - returned).partialPivLu();
  const Eigen::MatrixXcd inverse = lu.inverse();
  Loops loops{lu.determinant(), {}};
  for (Eigen::Index c = 0; c < returned.rows(); ++c) loops.alone.push_back(1.0 - 1.0 / inverse(c, c));
  return loops;
}

int LoopGroup::delay_frames() const {
  long frames = 0;
  for (const auto e : edges_) frames += graph_->edges[e].frames;
  return static_cast<int>(std::min(frames / frames_, 1'000'000L));
}

/// The shortest way from the cut back to itself, breadth first.
std::vector<std::string> LoopGroup::path_around(int cut) const {
  const int start = cuts_[index(cut)];
  std::map<int, std::size_t> came_by;
  std::deque<int> open{start};
  for (bool back = false; !open.empty() && !back; open.pop_front())
    for (const auto e : edges_) {
      const auto& edge = graph_->edges[e];
      if (edge.from != open.front() || came_by.contains(edge.to)) continue;
      came_by[edge.to] = e;
      open.push_back(edge.to);
      back = back || edge.to == start;
    }
  std::vector<std::string> way;
  if (!came_by.contains(start)) return way;
  int at = start;
  do {
    const auto& edge = graph_->edges[came_by.at(at)];
    if (!edge.path.empty() && (way.empty() || way.back() != edge.path)) way.push_back(edge.path);
    at = edge.from;
  } while (at != start);
  std::ranges::reverse(way);
  return way;
}

bool LoopGroup::contains(int network) const {
  return std::ranges::any_of(edges_, [&](auto e) { return graph_->edges[e].network == network; });
}

}  // namespace tactus
