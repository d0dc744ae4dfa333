#pragma once

// Thread: [any]
#include <cmath>
#include <numbers>

#include "engine/core/units.h"

namespace tactus {

/// Two equal real poles:  y'' = w^2 (x - y) - 2 w y',  stepped exactly for an input held over the step.
/// The -3 dB point is `bandwidth`: w = 2 pi bandwidth / sqrt(sqrt(2) - 1). The step response never
/// overshoots.
class CriticalLowPass {
 public:
  struct State {
    double value = 0.0, slope = 0.0;
  };

  /// bandwidth > 0.
  CriticalLowPass(Hertz bandwidth, Hertz step_rate)
      : pole_(2.0 * std::numbers::pi * bandwidth.value / std::sqrt(std::numbers::sqrt2 - 1.0)),
        step_(1.0 / step_rate.value),
        decay_(std::exp(-pole_ * step_)) {}

  /// [realtime]
  void step(State& state, double input) const noexcept {
    const double away = state.value - input;
    const double push = (state.slope + pole_ * away) * step_;
    state.value = input + (away + push) * decay_;
    state.slope = (state.slope - pole_ * push) * decay_;
  }

 private:
  double pole_, step_, decay_;
};

}  // namespace tactus
