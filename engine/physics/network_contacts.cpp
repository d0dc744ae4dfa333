#include <algorithm>
#include <cmath>

#include "engine/physics/network.h"

// Contacts of the passive solver. The indentation n moves by d = n+ - n- = 2w + (change), w = n - n-, and
//   F = g psi + (g^2/4 + r Fp / 2k) d,   psi+ = psi + g d / 2,
// where g is the slope of the root of the energy at n. The first two terms are g times the mean of psi and
// psi+, so that the masses lose exactly what psi^2/2 gains, whatever g is. So in the first step of a touch g
// is the slope of the chord to where the root is to be foreseen: the plain slope, which has a corner at n =
// 0, would leave psi off by a part that depends on the phase, and the contact's time with it (8e-3 at 20
// steps a contact; with the chord 1e-3). The last term of F is the loss. Fp is the force g (psi + psi+)/2 as
// it is to be foreseen (d = 2w), not the law's force at n: the ratio of speeds that a loss r leaves does not
// depend on the potential, so it comes out right for the potential that the scheme really has, a hundred
// times closer.
namespace tactus {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

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

}  // namespace

void Network::solve_masses(NetworkState& state) const noexcept {
  solver_matrix_.solve({state.change.data(), mass_.size()});
}

void Network::find_touching(NetworkState& state) const noexcept {
  state.touching.clear();
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const auto& contact = contacts_[c];
    const auto lower = index(contact.lower), upper = index(contact.upper);
    const double n = indentation_now(state, contact), psi = state.root[c];
    if (n < 0.0 && psi == 0.0) continue;
    const double w = state.moved[lower] - state.moved[upper];
    double g = 0.0, damping = 0.0;
    if (n >= 0.0) {
      watch_touch(state, c, n, w);
      const bool first = n <= w && w > 0.0 && psi == 0.0;
      g = first ? contact.law.root(n + 0.5 * w) / w : contact.law.root_slope(n);
      if (psi < 0.0) g = -g;
      damping = 0.5 * state.loss[c] * std::max(0.0, g * (psi + 0.5 * g * w)) / k_;
    } else if (w < -1e-30 && std::abs(psi) > kForgotten) {
      g = -psi / w;  // gives back what is left of the energy while the bodies part
    } else {
      if (std::abs(psi) <= kForgotten) state.root[c] = 0.0;
      continue;
    }
    const double motion = 2.0 * w + state.change[lower] - state.change[upper];
    state.touching.push_back({static_cast<int>(c), g, g * psi, 0.25 * g * g + damping, motion, 0.0});
  }
}

/// Forces F = F0 + S d of all that touch, where d = d_free - W F:  with y = sqrt(S) d,
/// (1 + sqrt(S) W sqrt(S)) y = sqrt(S) (d_free - W F0), symmetric and positive definite.
void Network::solve_forces(NetworkState& state) const noexcept {
  auto& touching = state.touching;
  const auto n = touching.size(), count = contacts_.size();
  const auto w = [&](const auto& a, const auto& b) {
    return mutual_[index(a.contact) * count + index(b.contact)];
  };
  if (n == 1) {
    auto& t = touching.front();
    t.force = (t.still + t.resistance * t.motion) / (1.0 + t.resistance * w(t, t));
    return;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double root = std::sqrt(touching[i].resistance);
    double free = touching[i].motion;
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

/// A contact that would have to pull is let go for the step: it keeps its energy and returns it when parting.
void Network::solve_touching(NetworkState& state) const noexcept {
  auto& touching = state.touching;
  do {
    if (touching.empty()) return;
    solve_forces(state);
  } while (std::erase_if(touching, [](const auto& touch) { return touch.force < 0.0; }) > 0);
  for (const auto& touch : touching) {
    const double* column = columns_.data() + index(touch.contact) * mass_.size();
    for (std::size_t i = 0; i < mass_.size(); ++i) state.change[i] -= column[i] * touch.force;
  }
  for (auto& touch : touching) {
    const auto lower = index(contacts_[index(touch.contact)].lower);
    const auto upper = index(contacts_[index(touch.contact)].upper);
    touch.motion =
        2.0 * (state.moved[lower] - state.moved[upper]) + state.change[lower] - state.change[upper];
    state.root[index(touch.contact)] += 0.5 * touch.slope * touch.motion;
  }
}

}  // namespace tactus
