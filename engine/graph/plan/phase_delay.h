#pragma once

// Thread: [control]; overrides of Node as it says.

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine/graph/node.h"
#include "engine/graph/semantics/interval.h"

namespace tactus {

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

}  // namespace tactus
