#pragma once

// Thread: [realtime]; constructors [control].

#include <array>
#include <complex>
#include <span>
#include <vector>

#include "engine/core/units.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// A mode of a body as it is felt at one point: rings at `frequency_hz`, is 60 dB down after `decay_s`, and
/// moves there like a mass of `mass_kg`.
struct BodyMode {
  double frequency_hz = 0;
  double decay_s = 1;  ///< clamped to [0.1 ms, 10000 s]
  double mass_kg = 1;
};

/// One mode at one sample rate: a mass, a damper and a spring that move together, each by the trapezoidal
/// rule,
///
///   F = f_m + c v + f_k,   f_m[n] + f_m[n-1] = 2 m fs (v[n] - v[n-1]),   f_k[n] - f_k[n-1] = k / (2 fs)
///   (v[n]
///   + v[n-1])
///
/// which is the bilinear transform of the admittance s / (m s^2 + c s + k). c and k are chosen so that the
/// pole of the discrete mode is exactly e^((-sigma + j 2 pi f) / fs), sigma = ln 1000 / decay:
///
///   p = 2 fs (e^(...) - 1) / (e^(...) + 1),   c = -2 m Re p,   k = m |p|^2
///
/// All three are positive, hence the admittance is positive real and no frequency gains energy.
struct BodyModeDesign {
  BodyModeDesign(const BodyMode& mode, Hertz sample_rate);
  /// v / F at any z^-1 [m/(N s)].
  std::complex<double> admittance(std::complex<double> delay) const;

  double mass_ohm;    ///< R_m = 2 m fs [N s/m]
  double loss_ohm;    ///< c
  double spring_ohm;  ///< R_k = k / (2 fs)
};

/// A body of many modes, all of which move with the point where it is touched, behind a port of impedance Z
/// for waves of force: `a` comes in, `b` goes out,
///
///   v = sum of v_k,   F = 2 a - Z v,   b = a - Z v
///   v_k = g (F + s_m - s_k),   s_m <- 2 R_m v_k - s_m,   s_k <- 2 R_k v_k + s_k,   g = 1 / (R_m + c + R_k)
///
/// F and v of one frame depend on each other; their equation is linear and is solved once, when the body is
/// made. The stored energy, sum of (s_m^2 / R_m + s_k^2 / R_k) / (4 fs), changes in a frame by exactly
/// ((a^2 - b^2) / Z - sum of c v_k^2) / fs: a port of the same impedance may be joined to it by any delay,
/// and nothing can become unstable. Source: Bilbao, Wave and Scattering Methods for Numerical Simulation,
/// Wiley, 2004, chapter 2.
class ModalBody {
 public:
  /// [control] Modes at half the sample rate or above are left out. impedance > 0 [N s/m].
  ModalBody(std::span<const BodyMode> modes, double impedance, Hertz sample_rate);

  /// What leaves in a frame.
  struct Answer {
    double wave, velocity, force, position;
  };
  /// [realtime] One frame; `wave` is `a` [N].
  Answer step(double wave) noexcept;
  void reset() noexcept;
  /// [realtime] Continues from the state of `other`, mode by mode, as far as there are as many.
  void adopt(const ModalBody& other) noexcept;

  /// [any] Energy stored in the modes [J].
  double energy() const noexcept;

 private:
  using Row = std::array<double, Lanes::kCount>;
  /// Eight modes; the states are those of the text times g.
  struct alignas(64) Bundle {
    Row give{};                          ///< g
    Row mass_turn{}, spring_turn{};      ///< 2 R_m g, 2 R_k g
    Row per_spring{};                    ///< position of a mode from its spring's state
    Row mass{}, spring{};                ///< g s_m, g s_k
    Row mass_energy{}, spring_energy{};  ///< of a state of 1 [J]
  };
  void add(const BodyModeDesign& design, std::size_t place, Hertz sample_rate);
  void sum_states() noexcept;

  std::vector<Bundle> bundles_;
  double impedance_, half_frame_s_;
  double by_wave_ = 0, by_state_ = 1;  ///< v = by_wave a + by_state sum of (g s_m - g s_k)
  double free_velocity_ = 0;           ///< that sum
};

}  // namespace tactus
