#pragma once

// Thread: [realtime]; constructors [control].

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

#include "engine/core/units.h"
#include "engine/dsp/resonators/modal_body_kernel.h"
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
///   F = f_m + c v + f_k,   f_m[n] + f_m[n-1] = 2 m fs (v[n] - v[n-1]),
///   f_k[n] - f_k[n-1] = k / (2 fs) (v[n] + v[n-1])
///
/// which is the bilinear transform of the admittance s / (m s^2 + c s + k), with sigma = ln 1000 / decay (c
/// and k: tactus_body_mode_of). All three are positive, hence the admittance is positive real and no
/// frequency gains energy.
struct BodyModeDesign : tactus_body_mode {
  BodyModeDesign(const BodyMode& mode, Hertz sample_rate)
      : tactus_body_mode{tactus_body_mode_of(
            mode.mass_kg, 3 * std::numbers::ln10 / std::clamp(mode.decay_s, 1e-4, 1e4) / sample_rate.value,
            std::numbers::pi * mode.frequency_hz / sample_rate.value, sample_rate.value)} {}
  /// v / F at any z^-1 [m/(N s)].
  std::complex<double> admittance(std::complex<double> delay) const {
    // 1 / (R_m d + c + R_k / d) with d = less / more.
    const auto less = 1.0 - delay, more = 1.0 + delay;
    return less * more / (mass_ohm * less * less + loss_ohm * less * more + spring_ohm * more * more);
  }
  double give() const { return 1 / (mass_ohm + loss_ohm + spring_ohm); }
};

/// `tactus_modal_body_step`, vectorised.
class ModalBody {
 public:
  /// [control] Modes at half the sample rate or above are left out. impedance > 0 [N s/m].
  ModalBody(std::span<const BodyMode> modes, double impedance, Hertz sample_rate) {
    double give = 0;
    int count = 0;
    for (const auto& mode : modes) {
      if (!(mode.frequency_hz > 0 && mode.frequency_hz < sample_rate.value / 2)) continue;
      const BodyModeDesign design{mode, sample_rate};
      add(design, count++, sample_rate);
      give += design.give();
    }
    body_.impedance = impedance;
    body_.half_frame = 0.5 / sample_rate.value;
    body_.by_state = 1 / (1 + impedance * give);
    body_.by_wave = 2 * give * body_.by_state;
  }

  /// [realtime] One frame; `wave` is `a` [N]. Not inlined: g++ would take a sign that its caller changes into
  /// the multiply-add, which turns -0 into 0.
  [[gnu::noinline]] tactus_body_answer step(double wave) noexcept {
    auto answer = tactus_modal_body_answer(&body_, wave);
    const auto push = Lanes::broadcast(answer.force);
    auto free = Lanes::broadcast(0), held = Lanes::broadcast(0);
    for (auto& group : groups_) {
      const auto mass = Lanes::load(group.mass), spring = Lanes::load(group.spring);
      const auto v = fused_multiply_add(Lanes::load(group.give), push, mass - spring);
      const auto new_mass = Lanes::load(group.mass_turn) * v - mass;
      const auto new_spring = fused_multiply_add(Lanes::load(group.spring_turn), v, spring);
      new_mass.store(group.mass);
      new_spring.store(group.spring);
      free = free + (new_mass - new_spring);
      held = fused_multiply_add(Lanes::load(group.per_spring), new_spring, held);
    }
    tactus_modal_body_close(&body_, &answer, free.sum(), held.sum());
    return answer;
  }

  void reset() noexcept {
    for (auto& group : groups_)
      for (auto* row : {&group.mass, &group.spring}) std::fill_n(*row, Lanes::kCount, 0.0);
    body_.free_velocity = 0;
  }

  /// [realtime] Continues from the state of `other`, mode by mode, as far as there are as many.
  void adopt(const ModalBody& other) noexcept {
    auto free = Lanes::broadcast(0);
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      auto& group = groups_[i];
      if (i < other.groups_.size()) {
        std::copy_n(other.groups_[i].mass, Lanes::kCount, group.mass);
        std::copy_n(other.groups_[i].spring, Lanes::kCount, group.spring);
      }
      free = free + (Lanes::load(group.mass) - Lanes::load(group.spring));
    }
    body_.free_velocity = free.sum();
  }

  /// [any] Eight modes in each.
  struct alignas(64) Group : tactus_body_modes {};
  const std::vector<Group>& groups() const { return groups_; }
  const tactus_modal_body& scalars() const { return body_; }

 private:
  void add(const BodyModeDesign& design, int place, Hertz sample_rate) {
    const double g = design.give();
    const int lane = place % Lanes::kCount;
    if (lane == 0) groups_.emplace_back();
    auto& group = groups_.back();
    group.give[lane] = g;
    group.mass_turn[lane] = 2 * design.mass_ohm * g;
    group.spring_turn[lane] = 2 * design.spring_ohm * g;
    group.per_spring[lane] = 1 / (g * 2 * sample_rate.value * design.spring_ohm);
  }

  std::vector<Group> groups_;
  tactus_modal_body body_{};
};

}  // namespace tactus
