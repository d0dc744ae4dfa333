#pragma once

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/support/graphs/node_runner.h"

namespace tactus::test {

/// H(f) of an impulse response that has died out.
inline std::complex<double> spectrum_at(const Samples& impulse_response, double hertz, double rate = 48000) {
  std::complex<double> sum = 0;
  for (std::size_t n = 0; n < impulse_response.size(); ++n)
    sum +=
        impulse_response[n] * std::polar(1.0, -2 * std::numbers::pi * hertz / rate * static_cast<double>(n));
  return sum;
}

inline double decibels(std::complex<double> response) { return 20 * std::log10(std::abs(response)); }

/// The response that a node states, with inputs held at `at`.
inline std::complex<double> stated_response(NodeRunner& runner, double hertz, std::vector<double> at,
                                            int output = 0) {
  return runner.node().response(0, output, on_circle(Hertz{hertz}, 48_kHz), at).value();
}

}  // namespace tactus::test
