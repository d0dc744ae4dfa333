#include "engine/dsp/resonators/modal_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus {

BodyModeDesign::BodyModeDesign(const BodyMode& mode, Hertz sample_rate) {
  const double fs = sample_rate.value;
  const double sigma = 3 * std::numbers::ln10 / std::clamp(mode.decay_s, 1e-4, 1e4);
  const auto pole = std::exp(std::complex{-sigma, 2 * std::numbers::pi * mode.frequency_hz} / fs);
  const auto p = 2 * fs * (pole - 1.0) / (pole + 1.0);
  mass_ohm = 2 * mode.mass_kg * fs;
  loss_ohm = -2 * mode.mass_kg * p.real();
  spring_ohm = mode.mass_kg * std::norm(p) / (2 * fs);
}

std::complex<double> BodyModeDesign::admittance(std::complex<double> delay) const {
  // 1 / (R_m d + c + R_k / d) with d = less / more.
  const auto less = 1.0 - delay, more = 1.0 + delay;
  return less * more / (mass_ohm * less * less + loss_ohm * less * more + spring_ohm * more * more);
}

ModalBody::ModalBody(std::span<const BodyMode> modes, double impedance, Hertz sample_rate)
    : impedance_(impedance), half_frame_s_(0.5 / sample_rate.value) {
  double give = 0;
  std::size_t place = 0;
  for (const auto& mode : modes) {
    if (!(mode.frequency_hz > 0 && mode.frequency_hz < sample_rate.value / 2)) continue;
    const BodyModeDesign design{mode, sample_rate};
    add(design, place++, sample_rate);
    give += 1 / (design.mass_ohm + design.loss_ohm + design.spring_ohm);
  }
  by_state_ = 1 / (1 + impedance * give);
  by_wave_ = 2 * give * by_state_;
}

void ModalBody::add(const BodyModeDesign& design, std::size_t place, Hertz sample_rate) {
  const double fs = sample_rate.value;
  const double g = 1 / (design.mass_ohm + design.loss_ohm + design.spring_ohm);
  const auto lane = place % Lanes::kCount;
  if (lane == 0) bundles_.emplace_back();
  auto& bundle = bundles_.back();
  bundle.give[lane] = g;
  bundle.mass_turn[lane] = 2 * design.mass_ohm * g;
  bundle.spring_turn[lane] = 2 * design.spring_ohm * g;
  bundle.per_spring[lane] = 1 / (g * 2 * fs * design.spring_ohm);
  bundle.mass_energy[lane] = 1 / (g * g * 4 * fs * design.mass_ohm);
  bundle.spring_energy[lane] = 1 / (g * g * 4 * fs * design.spring_ohm);
}

ModalBody::Answer ModalBody::step(double wave) noexcept {
  const double velocity = fused_multiply_add(by_wave_, wave, by_state_ * free_velocity_);
  const double out = fused_multiply_add(-impedance_, velocity, wave);
  const double force = wave + out;
  const auto push = Lanes::broadcast(force);
  auto free = Lanes::broadcast(0), held = Lanes::broadcast(0);
  for (auto& bundle : bundles_) {
    const auto mass = Lanes::load(bundle.mass.data()), spring = Lanes::load(bundle.spring.data());
    const auto v = fused_multiply_add(Lanes::load(bundle.give.data()), push, mass - spring);
    const auto new_mass = Lanes::load(bundle.mass_turn.data()) * v - mass;
    const auto new_spring = fused_multiply_add(Lanes::load(bundle.spring_turn.data()), v, spring);
    new_mass.store(bundle.mass.data());
    new_spring.store(bundle.spring.data());
    free = free + (new_mass - new_spring);
    held = fused_multiply_add(Lanes::load(bundle.per_spring.data()), new_spring, held);
  }
  free_velocity_ = free.sum();
  // A spring's state is that of half a frame later.
  return {out, velocity, force, fused_multiply_add(-half_frame_s_, velocity, held.sum())};
}

void ModalBody::sum_states() noexcept {
  auto free = Lanes::broadcast(0);
  for (const auto& bundle : bundles_)
    free = free + (Lanes::load(bundle.mass.data()) - Lanes::load(bundle.spring.data()));
  free_velocity_ = free.sum();
}

void ModalBody::reset() noexcept {
  for (auto& bundle : bundles_) bundle.mass = bundle.spring = {};
  free_velocity_ = 0;
}

void ModalBody::adopt(const ModalBody& other) noexcept {
  const auto count = std::min(bundles_.size(), other.bundles_.size());
  for (std::size_t i = 0; i < count; ++i) {
    bundles_[i].mass = other.bundles_[i].mass;
    bundles_[i].spring = other.bundles_[i].spring;
  }
  sum_states();
}

double ModalBody::energy() const noexcept {
  auto sum = Lanes::broadcast(0);
  for (const auto& bundle : bundles_) {
    const auto mass = Lanes::load(bundle.mass.data()), spring = Lanes::load(bundle.spring.data());
    sum = fused_multiply_add(Lanes::load(bundle.mass_energy.data()) * mass, mass, sum);
    sum = fused_multiply_add(Lanes::load(bundle.spring_energy.data()) * spring, spring, sum);
  }
  return sum.sum();
}

}  // namespace tactus
