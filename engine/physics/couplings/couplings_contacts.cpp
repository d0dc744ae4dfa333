#include <algorithm>
#include <cmath>

#include "engine/physics/couplings/couplings.h"

// Contacts and bonds: which of them act in a step, and the forces between them.
namespace tactus {
namespace {

// Energy below 1e-24 J that is left after parting: forgotten, so that the contact costs nothing while open.
constexpr double kForgotten = 1e-12;

/// L L^T x = b for the first `n` rows; `matrix` is overwritten.
void solve_cholesky(double* matrix, double* b, std::size_t n) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = matrix[i * n + j];
      for (std::size_t l = 0; l < j; ++l) sum -= matrix[i * n + l] * matrix[j * n + l];
      matrix[i * n + j] = i == j ? std::sqrt(sum) : sum / matrix[j * n + j];
    }
    for (std::size_t j = 0; j < i; ++j) b[i] -= matrix[i * n + j] * b[j];
    b[i] /= matrix[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    b[i] /= matrix[i * n + i];
    for (std::size_t j = 0; j < i; ++j) b[j] -= matrix[i * n + j] * b[i];
  }
}

/// Slope of the chord of the energy's root between two indentations.
double chord(const ContactLaw& law, double n, double motion) noexcept {
  const double to = std::max(0.0, n + motion), from = std::max(0.0, n);
  // Where the ends lie close the middle's slope is as good, and loses no digits.
  if (std::abs(motion) <= 1e-3 * n) return law.root_slope(n + 0.5 * motion);
  return (law.root(to) - law.root(from)) / motion;
}

}  // namespace

void Couplings::find_contacts(NetworkState& state) const noexcept {
  for (std::size_t c = 0; c < model_->contacts.size(); ++c) {
    Touch touch{.coupling = static_cast<int>(c)};
    const double n = indentation(state, c);
    if (method_ == Method::Gradient) {
      touch.free = motion(state, c);
      const double w = moved(state, c), before = n - w;
      if (std::max({n, before, before + touch.free}) <= 0.0) continue;
      if (n >= 0.0) watch_touch(*model_, state, c, n, w);
      state.touching.push_back(touch);
    } else if (method_ == Method::Exact ? foresee_exact(state, touch) : foresee_centred(state, touch)) {
      state.touching.push_back(touch);
    }
  }
}

/// What is left of the energy goes back into the bodies while they part; `motion` is how they are to.
bool Couplings::let_go(NetworkState& state, Touch& touch, double motion) const noexcept {
  double& psi = state.root[at(touch.coupling)];
  if (std::abs(psi) <= kForgotten) psi = 0.0;
  if (psi == 0.0 || motion >= -1e-30) return false;
  touch.slope = -psi / motion;
  return true;
}

/// Whether a touch that begins is over sooner than a step shows: then it is the damper of its restitution.
bool Couplings::bounce(const NetworkState& state, Touch& touch) const noexcept {
  const auto c = at(touch.coupling);
  const double approach = moved(state, c), loss = state.loss[c], own = mutual(c, c);
  if (loss == 0.0 || approach <= 0.0 || state.root[c] != 0.0 || own == 0.0) return false;
  const double loss_speed = loss * approach / model_->k;
  // m v^2 of the two bodies, m = k^2 steps / 2 W.
  const double twice_kinetic = 0.5 * steps() * approach * approach / own;
  if (model_->contacts[c].law.energy(approach) <= twice_kinetic * stored_at_deepest(loss_speed)) return false;
  const double e = restitution_of(loss_speed);
  if (e >= 1.0) return false;
  touch.resistance = (1.0 + e) / ((1.0 - e) * own);
  touch.free = motion(state, c);
  return true;
}

bool Couplings::foresee_centred(NetworkState& state, Touch& touch) const noexcept {
  const auto c = at(touch.coupling);
  const auto& law = model_->contacts[c].law;
  const double n = indentation(state, c), psi = state.root[c];
  if (n < 0.0 && psi == 0.0) return false;
  const double w = moved(state, c);
  double damping = 0.0;
  if (n >= 0.0) {
    watch_touch(*model_, state, c, n, w);
    if (bounce(state, touch)) return true;
    const bool first = n <= w && w > 0.0 && psi == 0.0;
    const double g = first ? law.root(n + 0.5 * w) / w : law.root_slope(n);
    touch.slope = psi < 0.0 ? -g : g;
    const double force = touch.slope * (psi + 0.5 * touch.slope * w);
    damping = 0.5 * state.loss[c] * std::max(0.0, force) / model_->k;
  } else if (!let_go(state, touch, w)) {
    return false;
  }
  touch.still = touch.slope * psi;
  touch.resistance = 0.25 * touch.slope * touch.slope + damping;
  touch.free = motion(state, c);
  return true;
}

/// What the present forces take off the motion of contact c.
double Couplings::foreseen_push(const NetworkState& state, std::size_t c) const noexcept {
  double sum = 0.0;
  const auto add = [&](std::size_t other) {
    const double n = indentation(state, other);
    if (n <= 0.0) return;
    const double rate = 1.0 + state.loss[other] * moved(state, other) / model_->k;
    sum += mutual(c, other) * model_->contacts[other].law.force(n) * std::max(0.0, rate);
  };
  if (alone_) {
    add(c);
  } else {
    for (std::size_t other = 0; other < model_->contacts.size(); ++other) add(other);
  }
  return sum;
}

/// The motion that is to be foreseen is the free one less what the present force does to it.
bool Couplings::foresee_exact(NetworkState& state, Touch& touch) const noexcept {
  const auto c = at(touch.coupling);
  const auto& law = model_->contacts[c].law;
  const double n = indentation(state, c), psi = state.root[c];
  touch.free = motion(state, c);
  const double motion = touch.free - foreseen_push(state, c);
  if (n <= 0.0 && n + motion > 0.0) watch_touch(*model_, state, c, n, moved(state, c));
  double damping = 0.0;
  if (n >= 0.0 || n + motion > 0.0) {
    if (bounce(state, touch)) return true;
    const double g = motion == 0.0 ? law.root_slope(std::max(0.0, n)) : chord(law, n, motion);
    touch.slope = psi < 0.0 ? -g : g;
    const double force = touch.slope * (psi + 0.5 * touch.slope * motion);
    damping = state.loss[c] * std::max(0.0, force) / model_->k;
  } else if (!let_go(state, touch, motion)) {
    return false;
  }
  touch.still = touch.slope * psi;
  touch.resistance = 0.5 * touch.slope * touch.slope + damping;
  return true;
}

void Couplings::find_bonds(NetworkState& state) const noexcept {
  const auto contacts = model_->contacts.size();
  for (std::size_t b = 0; b < model_->bonds.size(); ++b) {
    const auto c = contacts + b;
    const auto& bond = model_->bonds[b];
    const double n = indentation(state, c);
    if (state.slipped[b] * n < 0.0) state.slipped[b] = state.root[c] = 0.0;
    if (state.slipped[b] != 0.0) continue;
    Touch touch{.coupling = static_cast<int>(c)};
    if (method_ == Method::Pushed) {
      state.root[c] = bond.law->root(n);
      touch.force = bond.law->force(n) + bond.damping * moved(state, c) / model_->k;
    }
    touch.free = motion(state, c);
    bend(state, touch, touch.free);
    state.touching.push_back(touch);
  }
}

/// The force of a bond as it follows from a motion of this size. True if it differs from what it was.
bool Couplings::bend(const NetworkState& state, Touch& touch, double motion) const noexcept {
  constexpr double kEnough = 1e-15;
  const auto c = at(touch.coupling);
  const auto& bond = model_->bonds[c - model_->contacts.size()];
  const double n = indentation(state, c), from = method_ == Method::Exact ? n : n - 0.5 * moved(state, c);
  const auto chord = bond.law->chord(from, from + motion / steps());
  const bool changed = std::abs(chord.slope - touch.slope) > kEnough * chord.slope;
  touch.slope = chord.slope;
  touch.still = touch.slope * state.root[c];
  touch.resistance = chord.square / (2.0 * steps()) + bond.damping / slack();
  return changed;
}

/// Whether the motions that the forces make bend a bond further than was thought.
bool Couplings::bend_bonds(NetworkState& state) const noexcept {
  bool changed = false;
  for (auto& touch : state.touching) {
    const auto c = at(touch.coupling), contacts = model_->contacts.size();
    if (c < contacts || model_->bonds[c - contacts].law->linear()) continue;
    changed |= bend(state, touch, touch.free - rubbed(state, c) - pushed(state, c));
  }
  return changed;
}

/// The scheme of mass-interaction: from the present state.
void Couplings::push_contacts(NetworkState& state) const noexcept {
  for (std::size_t c = 0; c < model_->contacts.size(); ++c) {
    const double n = indentation(state, c);
    if (n <= 0.0) continue;
    const double motion = moved(state, c);
    watch_touch(*model_, state, c, n, motion);
    const double rate = 1.0 + state.loss[c] * motion / model_->k;
    state.touching.push_back(
        {.coupling = static_cast<int>(c), .force = std::max(0.0, model_->contacts[c].law.force(n) * rate)});
  }
}

void Couplings::solve_contacts(NetworkState& state) const noexcept {
  if (method_ == Method::Pushed || state.touching.empty()) return;
  if (method_ != Method::Gradient) return solve_quadratised(state);
  do solve_gradient(state);
  while (!alone_ && missed_one(state));
}

/// A contact that would have to pull is let go for the step: it keeps its energy and returns it when parting.
void Couplings::solve_quadratised(NetworkState& state) const noexcept {
  const auto pulls = [this](const Touch& touch) {
    return touch.force < 0.0 && at(touch.coupling) < model_->contacts.size();
  };
  constexpr int kMostRounds = 30;
  for (int round = 0; round < kMostRounds; ++round) {
    do {
      if (state.touching.empty()) return;
      solve_linear(state);
    } while (std::erase_if(state.touching, pulls) > 0);
    if (model_->bonds.empty() || !bend_bonds(state)) return;
  }
  solve_linear(state);
}

/// Forces F = F0 + S d of all that touch, where d = d_free - W F:  with y = sqrt(S) d,
/// (1 + sqrt(S) W sqrt(S)) y = sqrt(S) (d_free - W F0), symmetric and positive definite.
void Couplings::solve_linear(NetworkState& state) const noexcept {
  auto& touching = state.touching;
  const auto n = touching.size();
  const auto w = [&](const Touch& a, const Touch& b) { return mutual(at(a.coupling), at(b.coupling)); };
  if (n == 1 || alone_) {
    for (auto& t : touching) {
      const double free = t.free - (alone_ ? 0.0 : rubbed(state, at(t.coupling)));
      t.force = (t.still + t.resistance * free) / (1.0 + t.resistance * w(t, t));
    }
    return;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double root = std::sqrt(touching[i].resistance);
    double free = touching[i].free - rubbed(state, at(touching[i].coupling));
    for (std::size_t j = 0; j < n; ++j) {
      const double mutual = w(touching[i], touching[j]);
      free -= mutual * touching[j].still;
      state.matrix[i * n + j] = (i == j ? 1.0 : 0.0) + root * mutual * std::sqrt(touching[j].resistance);
    }
    state.right[i] = root * free;
  }
  solve_cholesky(state.matrix.data(), state.right.data(), n);
  for (std::size_t i = 0; i < n; ++i)
    touching[i].force = touching[i].still + std::sqrt(touching[i].resistance) * state.right[i];
}

/// F and its slope at the motion d that is known by now:  F = G(d) (1 + r d / 2k), G = (phi(n- + d) -
/// phi(n-)) / d, both convex and never below 0.
void Couplings::follow(const NetworkState& state, Touch& touch) const noexcept {
  const auto c = at(touch.coupling);
  if (c >= model_->contacts.size()) {
    bend(state, touch, touch.motion);
    return;
  }
  const auto& law = model_->contacts[c].law;
  const auto energy = [&](double n) { return n > 0.0 ? law.energy(n) : 0.0; };
  const auto force = [&](double n) { return n > 0.0 ? law.force(n) : 0.0; };
  const double from = indentation(state, c) - moved(state, c), d = touch.motion, to = from + d;
  double g, slope;
  if (std::abs(d) <= 1e-7 * std::abs(from)) {
    g = force(from + 0.5 * d);
    slope = from > 0.0 ? 0.5 * law.stiffness(from) : 0.0;
  } else {
    g = (energy(to) - energy(from)) / d;
    slope = (force(to) - g) / d;
  }
  const double loss = state.loss[c] / slack(), rate = std::max(0.0, 1.0 + loss * d);
  touch.force = g * rate;
  touch.resistance = std::max(0.0, slope * rate + (rate > 0.0 ? g * loss : 0.0));
  touch.still = touch.force - touch.resistance * d;
}

/// Newton's method, from the free motion down: what is sought is the zero of a convex function of each
/// motion.
void Couplings::solve_gradient(NetworkState& state) const noexcept {
  constexpr int kMostSteps = 60;
  for (auto& touch : state.touching) touch.motion = touch.free - rubbed(state, at(touch.coupling));
  double before = 1e300;
  for (int i = 0; i < kMostSteps; ++i) {
    for (auto& touch : state.touching) follow(state, touch);
    solve_linear(state);
    double left = 0.0;
    for (auto& touch : state.touching) {
      const auto c = at(touch.coupling);
      const double next = touch.free - rubbed(state, c) - pushed(state, c), by = next - touch.motion;
      left = std::max(left, std::abs(by) / (std::abs(next) + std::abs(touch.free)));
      touch.motion += left > before ? 0.5 * by : by;
    }
    if (!(left > 1e-15)) break;
    before = left;
  }
}

/// Whether what touches pushes another contact together that was not thought to touch; adds it.
bool Couplings::missed_one(NetworkState& state) const noexcept {
  const auto found = state.touching.size();
  for (std::size_t c = 0; c < model_->contacts.size(); ++c) {
    const auto known = [&](const Touch& touch) { return at(touch.coupling) == c; };
    if (std::any_of(state.touching.begin(), state.touching.begin() + static_cast<std::ptrdiff_t>(found),
                    known))
      continue;
    const double free = motion(state, c);
    const double to = free - rubbed(state, c) - pushed(state, c);
    if (indentation(state, c) - moved(state, c) + to > 0.0)
      state.touching.push_back({.coupling = static_cast<int>(c), .free = free});
  }
  return state.touching.size() > found;
}

}  // namespace tactus
