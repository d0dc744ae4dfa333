#pragma once

// Thread: [any].

#include <Eigen/Core>
#include <complex>
#include <string>
#include <vector>

#include "engine/study/stability/models/stability_graph.h"

namespace tactus {

/// A strongly connected part of a graph, cut open at some signals:
///     r = R(z) v,    the loop is closed by v = r,    f(z) = det(1 - R(z)),
/// where v are the signals at the cuts and r what returns to them. The zeros of f are the roots of the
/// closed loops. As every loop has a delay, R goes to what is smaller than 1 where z goes to infinity, and f
/// has no poles outside the unit circle but those that the nodes have there.
///
/// Sampled once in S frames (a part with a rate of its own, a `sample_hold`), the cuts are what is sampled
/// and R is that from sample to sample. With Z = z^S, h the response of what holds, and F what lies between
/// it and the sampler, other loops closed, everything that the sampler folds together is in
///     R(Z) = sum_k F(z_k) h(z_k),    z_k = Z^(1/S) e^(j 2 pi k / S),
/// with h = (1 + z^-1 + ... + z^-(S - 1)) / S for what is held.
class LoopGroup {
 public:
  /// `signals`: a strongly connected part of the graph; `wanted`: signals that must be cut.
  LoopGroup(const LinearGraph& graph, std::vector<int> signals, const std::vector<int>& wanted);
  /// The same, sampled once in so many frames.
  static LoopGroup sampled(const LinearGraph& graph, std::vector<int> signals, int frames);

  const LinearGraph& graph() const { return *graph_; }
  const std::vector<int>& signals() const { return signals_; }
  /// Of a sampled group those that are sampled.
  const std::vector<int>& cuts() const { return cuts_; }
  const std::vector<std::size_t>& edges() const { return edges_; }  ///< inside the group
  int frames() const { return frames_; }                            ///< between two samples; 1: every frame
  /// Too many nested loops to analyse: nothing below may be called.
  bool too_large() const { return cuts_.size() + inner_cuts_.size() > kMostCuts; }
  /// Its delays are longer than `kLongestDelay`: its turns are not counted safely.
  bool too_long() const { return delay_frames() > kLongestDelay; }
  static constexpr int kLongestDelay = 75'000;  ///< [frames]
  /// Index in `cuts`, or -1.
  int cut(int signal) const;
  Eigen::MatrixXcd returned(std::complex<double> z) const;
  /// Of each edge.
  const std::vector<std::complex<double>>& gains_at(std::complex<double> z) const;
  /// f of `returned`.
  static std::complex<double> characteristic(const Eigen::MatrixXcd& returned);
  struct Loops {
    std::complex<double> f;
    std::vector<std::complex<double>> alone;  ///< of each cut the open-loop gain if it alone is open
  };
  /// f, and L = 1 - 1 / ((1 - R)^-1)_cc, of `returned`.
  static Loops loops(const Eigen::MatrixXcd& returned);
  /// Frames in all its delays together: the most turns of f around 0.
  int delay_frames() const;
  /// The shortest loop through a cut: the paths of its nodes.
  std::vector<std::string> path_around(int cut) const;
  bool contains(int network) const;

 private:
  Eigen::MatrixXcd returned_each_frame(std::complex<double> z) const;
  bool holds(std::size_t edge) const;
  void choose_cuts(const std::vector<int>& wanted);
  void put_in_order();

  const LinearGraph* graph_;
  static constexpr std::size_t kMostCuts = 48;
  std::vector<int> signals_, cuts_, inner_cuts_;  ///< inner: of a sampled group, in every frame
  int frames_ = 1;
  std::vector<std::size_t> edges_;                  ///< inside the group
  std::vector<int> order_;                          ///< all but the cuts, each behind what it reads
  std::vector<int> place_;                          ///< [signal of the graph] in `signals_`, or -1
  std::vector<std::vector<std::size_t>> incoming_;  ///< [place] edges
  mutable std::vector<std::complex<double>> gains_;
  mutable std::vector<std::complex<double>> values_;  ///< [place, cut] what reaches the signal from the cut
  mutable bool held_only_ = false;                    ///< nothing goes from samples to frames
};

/// [any] How many frames lie between two samples of what is sampled in these loops: 1: nothing is; 0: there
/// are several numbers.
int frames_between_samples(const LinearGraph& graph, const std::vector<int>& signals);

/// [any] Strongly connected parts with a loop in them, each as a list of signals. With `events`, edges of
/// events close loops as well.
std::vector<std::vector<int>> loops_of(const LinearGraph& graph, bool events);

}  // namespace tactus
