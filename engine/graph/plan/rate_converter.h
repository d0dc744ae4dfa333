#pragma once

// Thread: [control]; overrides of Node as it says.

#include <string>

#include "engine/core/units.h"
#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

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

}  // namespace tactus
