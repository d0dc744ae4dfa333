#pragma once

// Thread: [realtime]; constructors [control].

#include <array>
#include <complex>
#include <vector>

#include "engine/core/units.h"
#include "engine/dsp/simd/lanes.h"

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
/// An impulse of 1 at frame 0 gives gain r^n sin(w n). Stable: r < 1 for every decay. It runs on differences,
/// which keep the frequency of a low mode to a rounding, where 2 r cos(w) would lose a factor 1 / w^2:
///
///   d[n] = y[n] - y[n-1] = turn d[n-1] - pull y[n-2] + x[n-1]
///   turn = 2 r cos(w) - 1,  pull = 1 - 2 r cos(w) + r^2 = (1 - r)^2 + 4 r sin^2(w / 2)
///
/// A mode that is retuned while it rings continues with the same phase and amplitude: with P[n] = r e^(jw)
/// (P[n-1]
/// + x[n-1]), out = gain Im P, it is P that stays. So no movement of the frequency adds energy.
///
/// Source: Rabiner & Gold, Theory and Application of Digital Signal Processing, 1975, section 4.5;
/// sensitivity: Agarwal & Burrus, "New recursive digital filter structures having very low sensitivity and
/// roundoff noise", IEEE Trans. Circuits and Systems 22(12), 1975.
struct ModeDesign {
  ModeDesign(const Mode& mode, Hertz sample_rate);
  /// From x to out, at any z^-1.
  std::complex<double> response(std::complex<double> delay) const {
    return gain * delay / ((1.0 - delay) * (1.0 - turn * delay) + pull * delay * delay);
  }

  double turn = -1, pull = 1, gain = 0;  ///< silent: forgets at once
  double cosine = 0, sine = 0;           ///< r cos(w), r sin(w)
};

/// Many resonators with one input, summed. Eight modes share a vector register, and four registers step
/// together through the frames, so that the latency of one is hidden by the others. The order of additions
/// is fixed: each lane adds its modes in their order, the lanes are added last. So the output is the same for
/// any cutting into blocks. Error against exact arithmetic: a rounding of y a frame while the mode lasts.
class ModalBank {
 public:
  /// [control] All modes are silent.
  explicit ModalBank(int modes);

  /// [realtime] From the next frame on; ringing continues.
  void set(int mode, const ModeDesign& design) noexcept;
  /// [realtime] `in_before[n]` is the input one frame before `out[n]`; the two may be the same memory.
  void run(const double* in_before, double* out, int frames) noexcept;
  void reset() noexcept;
  /// [realtime] Continues from the state of `other`, mode by mode, as far as there are as many, until `set`.
  void adopt(const ModalBank& other) noexcept;

 private:
  using Row = std::array<double, Lanes::kCount>;
  /// Eight modes.
  struct alignas(64) Bundle {
    Row turn{}, minus_pull{}, gain{}, cosine{}, sine{};
    Row last{}, before{}, change{};  ///< y[n-1], y[n-2] and their difference
  };
  template <int Count>
  class InRegisters;
  static constexpr int kMaxFrames = 64;  ///< frames worked on at once
  struct alignas(64) Sums {
    std::array<Row, kMaxFrames> rows;
  };

  static void retune(Bundle& bundle, std::size_t lane, const ModeDesign& design) noexcept;
  void run_block(const double* x, double* y, int frames) noexcept;
  template <int Count>
  static void advance(Bundle* bundles, const double* x, Sums& sums, int frames) noexcept;

  int modes_;
  std::vector<Bundle> bundles_;
};

}  // namespace tactus
