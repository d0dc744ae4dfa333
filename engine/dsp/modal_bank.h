#pragma once

#include <array>
#include <complex>
#include <vector>

#include "engine/core/units.h"
#include "engine/dsp/lanes.h"

namespace tactus {

/// A damped sine: h(t) = gain e^(-t / tau) sin(2 pi frequency t), 60 dB down after `decay_s`, tau = decay /
/// ln 1000. In a bank silent from half the sample rate up; the decay is clamped to [0.1 ms, 10000 s].
struct Mode {
  double frequency_hz = 0;
  double decay_s = 1;
  double gain = 1;
};

/// The resonator with exactly these samples (impulse invariance):
///
///   y[n] = 2 r cos(w) y[n-1] - r^2 y[n-2] + x[n-1],  out = gain r sin(w) y
///   w = 2 pi frequency / fs,  r = e^(-1 / (tau fs))
///
/// An impulse of 1 at frame 0 gives gain r^n sin(w n). Stable: r < 1 for every decay. Source: Rabiner & Gold,
/// Theory and Application of Digital Signal Processing, 1975, section 4.5.
struct ModeDesign {
  ModeDesign(const Mode& mode, Hertz sample_rate);
  /// From x to out, at any z^-1.
  std::complex<double> response(std::complex<double> delay) const {
    return gain * delay / (1.0 - delay * (a1 + delay * a2));
  }

  double a1 = 0, a2 = 0, gain = 0;
};

/// Many resonators with one input, summed. Eight modes share a vector register, and four registers step side
/// by side through the frames of a piece, so that none waits for its own last result. The order of additions
/// is fixed: each lane adds its modes in their order, the lanes are added last. So the output is the same for
/// any cutting into blocks. Error against exact arithmetic: a rounding of y a frame, 1e-16 / w of the peak,
/// while the mode lasts.
class ModalBank {
 public:
  /// [control] All modes are silent.
  explicit ModalBank(int modes);

  /// [realtime] From the next frame on.
  void set(int mode, const ModeDesign& design) noexcept;
  /// [realtime] `in_before[n]` is the input one frame before `out[n]`; the two may be the same memory.
  void run(const double* in_before, double* out, int frames) noexcept;
  void reset() noexcept;
  /// [realtime] Goes on sounding as `other` did, mode by mode, as far as there are as many.
  void adopt(const ModalBank& other) noexcept;

 private:
  using Row = std::array<double, Lanes::kCount>;
  /// Eight modes.
  struct alignas(64) Bundle {
    Row a1{}, a2{}, gain{};
    Row last{}, before{};  ///< y[n-1], y[n-2]
  };
  template <int Count>
  class InRegisters;
  static constexpr int kLongest = 64;  ///< frames worked on at once
  struct alignas(64) Sums {
    std::array<Row, kLongest> rows;
  };

  void run_piece(const double* x, double* y, int frames) noexcept;
  template <int Count>
  static void advance(Bundle* bundles, const double* x, Sums& sums, int frames) noexcept;

  std::vector<Bundle> bundles_;
};

}  // namespace tactus
