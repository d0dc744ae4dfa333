#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "latency/estimation/fourier.h"
#include "latency/estimation/loop_recording.h"

namespace tactus::test {

/// A path through which a probe goes and comes back, exact up to rounding.
struct SimulatedLoop {
  double delay_frames = 1000.0;
  double gain = 1.0;                      ///< of either sign
  std::vector<double> high_pass_hz = {};  ///< corners of coupling capacitors
  double noise = 0.0;                     ///< rms of what is added, white and normal
  int bits = 0;                           ///< of the converter; 0: none
  std::uint64_t seed = 1;

  /// What comes back of `played`: `tail` frames more than were played and the delay has. The delay is a
  /// rotation of the phase, so a fraction of a frame is exact.
  LoopRecording record(const std::vector<double>& played, Hertz sample_rate, std::int64_t tail = 4800) const {
    const auto frames =
        played.size() + static_cast<std::size_t>(std::ceil(delay_frames)) + static_cast<std::size_t>(tail);
    Fourier fourier{frames + 4096};
    auto spectrum = fourier.forward(played);
    spectrum[0] *= high_pass_hz.empty() ? gain : 0.0;
    for (std::size_t b = 1; b < spectrum.size(); ++b) {
      const double w = 2 * std::numbers::pi * static_cast<double>(b) / static_cast<double>(fourier.size());
      spectrum[b] *= gain * std::polar(1.0, -w * delay_frames);
      const std::complex<double> s{0.0, w * sample_rate.value / (2 * std::numbers::pi)};
      for (const double corner : high_pass_hz) spectrum[b] *= s / (s + corner);
    }
    auto captured = fourier.inverse(spectrum);
    captured.resize(frames);
    std::mt19937_64 random{seed};
    std::normal_distribution<double> normal;
    for (auto& sample : captured) {
      if (noise > 0.0) sample += noise * normal(random);
      if (bits > 0) sample = quantised(sample);
    }
    LoopRecording recording{sample_rate, played, {std::move(captured)}};
    recording.played.resize(frames, 0.0);
    return recording;
  }

 private:
  double quantised(double sample) const {
    const double steps = std::exp2(bits - 1);
    return std::clamp(std::round(sample * steps), -steps, steps - 1.0) / steps;
  }
};

}  // namespace tactus::test
