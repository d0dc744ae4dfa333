#pragma once

// Thread: [control]; overrides as declared in Node.

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/interval.h"

namespace tactus {

// The nodes that the compiler inserts between those of a file.

/// Takes the phase delay of another node off a delay time, or adds it, at the frequency that the loop is
/// tuned to:
///
///   out = time + sign φ(f),   f = 1 / tuned,   φ(f) = −arg H(f) / (2π f)
///
/// Inputs: time [s], tuned [s], then the inputs of the other node (its parameters decide H). Output [s].
/// The phase is taken between −π and π, which is right for what sits in a tuned loop: filters that turn less
/// than half a circle at the fundamental.
class PhaseDelay : public Node {
 public:
  PhaseDelay(std::shared_ptr<const Node> other, int other_inputs, Hertz sample_rate, double sign)
      : other_(std::move(other)), sample_rate_(sample_rate), sign_(sign), values_(index(other_inputs), 0.0) {}

  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override { known_ = false; }

  /// [control] φ for a time that is tuned to `tuned`, the other node's inputs being `inputs`.
  static std::optional<double> at(const std::shared_ptr<const Node>& other, double tuned,
                                  const std::vector<double>& inputs, Hertz sample_rate);

  /// [control] All that φ can be over these ranges, by sampling frequencies and corners; negative for
  /// a phase that leads. nullopt: the other node has no response.
  static std::optional<Interval> range(const std::shared_ptr<const Node>& other, Interval tuned,
                                       const std::vector<Interval>& inputs, Hertz sample_rate);

 private:
  std::optional<double> phase_delay(double tuned) const noexcept;

  /// Only its design is asked, never its state: it may be another one than runs after an edit.
  std::shared_ptr<const Node> other_;
  Hertz sample_rate_;
  double sign_;
  std::vector<double> values_;
  double tuned_ = 0;
  double result_ = 0;
  bool known_ = false;
};

/// One lane of a signal that goes into a part with a rate of its own, or out of it. With R frames outside
/// (n = 0, 1, …) for each inside (m = 0, 1, …; frame m lies at n = R m):
///
///   into    last      y[m] = x[R m]
///           smooth    y[m] = (x[R m − R + 1] + … + x[R m]) / R           (R − 1)/2 frames late
///           trigger   y[m] = the largest of the same
///   out of  last      x[R m + j] = y[m],  0 <= j < R                      (R − 1)/2 frames late on average
///           smooth    x[R m + j] = (1 − j/R) y[m − 1] + j/R y[m]          R frames late
///           trigger   x[R m] = y[m], else 0
///
/// The grid is that of absolute frames, so that blocks change nothing. It runs in frames of the faster side,
/// only `last` on its way in runs in those of the slower one. A reset begins like the first frame.
class RateConverter : public Node {
 public:
  RateConverter(const RateConversion& how, int divisor, Hertz fast_rate);

  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override;
  void copy(const Node& other) noexcept override { assign(*this, other); }
  DelayRange delay(int, int) const override;
  /// Of what stays below half the lower rate; images of it are left out.
  std::optional<std::complex<double>> response(int input, int output, std::complex<double> z,
                                               std::span<const double> at) const override;
  std::string about() const override;

  /// Player frames between two of the frames that it runs in.
  static int runs_every(const RateConversion& how, int divisor);

 private:
  void take(const NodeBlock& block) noexcept;
  void give(const NodeBlock& block) noexcept;
  double between(std::int64_t position) const noexcept;

  RateConversion::How how_;
  bool into_;
  int ratio_;
  Hertz fast_rate_;
  double gathered_ = 0;             ///< into: of the frames since the last one inside
  double before_ = 0, latest_ = 0;  ///< out of: samples inside
  bool started_ = false;
};

/// One operator of an expression on kVectorWidth lanes, as in `evaluate`.
class VectorOperation : public Node {
 public:
  explicit VectorOperation(Expression::Op op) : op_(op) {}
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}

 private:
  Expression::Op op_;
};

/// kVectorWidth scalar signals as one vectorised signal.
class Pack : public Node {
 public:
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}
};

/// The sum of `lanes` lanes of vectorised signals, in the order of `add_lanes`.
class LaneSum : public Node {
 public:
  explicit LaneSum(int lanes) : lanes_(lanes) {}
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}

 private:
  int lanes_;
  std::array<double, index(kVectorWidth) * kMaxSubBlock> sums_;
};

/// The order in which `mix` adds lanes, which decides the last bits of its sum: lane k takes in lanes k + 8,
/// k + 16 … one after the other; what is then left is added in halves, k and k + 4, k and k + 2, k and k + 1.
template <class Value, class Add>
Value add_lanes(const std::vector<Value>& lanes, Add add) {
  constexpr std::size_t kStrands = kVectorWidth;
  std::vector<Value> strands;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    if (i < kStrands)
      strands.push_back(lanes[i]);
    else
      strands[i % kStrands] = add(strands[i % kStrands], lanes[i]);
  }
  for (std::size_t half = kStrands / 2; half > 0; half /= 2)
    for (; strands.size() > half; strands.pop_back())
      strands[strands.size() - 1 - half] = add(strands[strands.size() - 1 - half], strands.back());
  return strands.front();
}

}  // namespace tactus
