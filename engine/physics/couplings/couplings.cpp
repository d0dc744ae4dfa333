#include "engine/physics/couplings/couplings.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace tactus {
namespace {

// What may be kept for how each coupling acts on each other and on every mass.
constexpr std::size_t kCouplingsMostNumbers = 8'000'000;

// Rounds between contacts and frictions that act on each other; few are ever needed.
constexpr int kMostRounds = 60;

}  // namespace

Result<Couplings> Couplings::make(const NetworkModel& model, Method method,
                                  const std::function<void(std::span<double>)>& respond) {
  Couplings made;
  made.model_ = &model;
  made.method_ = method;
  const auto add = [&](const auto& list) {
    for (const auto& c : list) made.lower_.push_back(c.lower), made.upper_.push_back(c.upper);
  };
  add(model.contacts), add(model.bonds), add(model.frictions);
  const auto count = made.count(), masses = model.mass.size();
  const bool keep = method != Method::Pushed;
  made.first_row_ = keep ? 0 : made.first_friction();
  if (count * (keep ? masses + 2 * count : made.frictions()) > kCouplingsMostNumbers)
    return fail(Errc::OutOfRange, {},
                std::to_string(count) + " contacts among " + std::to_string(masses) +
                    " masses are more than this solver takes",
                "use solver = \"explicit\"");
  made.mutual_.resize((count - made.first_row_) * count);
  if (made.mutual_.empty() && !keep) return made;
  std::vector<double> column(masses);
  const auto between = [&](std::size_t c) {
    const auto place = [&](int slot) { return model.is_mass(slot) ? column[at(slot)] : 0.0; };
    return place(made.lower_[c]) - place(made.upper_[c]);
  };
  for (std::size_t c = 0; c < count; ++c) {
    std::fill(column.begin(), column.end(), 0.0);
    if (model.is_mass(made.lower_[c])) column[at(made.lower_[c])] += 1.0;
    if (model.is_mass(made.upper_[c])) column[at(made.upper_[c])] -= 1.0;
    respond(column);
    if (keep) made.columns_.insert(made.columns_.end(), column.begin(), column.end());
    for (std::size_t row = made.first_row_; row < count; ++row) {
      made.mutual_[(row - made.first_row_) * count + c] = between(row);
      made.alone_ = made.alone_ && (row == c || between(row) == 0.0);
    }
  }
  return made;
}

double Couplings::indentation(const NetworkState& state, std::size_t c) const noexcept {
  const double offset = c < model_->contacts.size() ? model_->contacts[c].offset : 0.0;
  return state.position[at(lower_[c])] - state.position[at(upper_[c])] + offset;
}

/// How far it moved in the last step, or would in this one by its velocity alone.
double Couplings::moved(const NetworkState& state, std::size_t c) const noexcept {
  const auto lower = at(lower_[c]), upper = at(upper_[c]);
  return method_ == Method::Exact ? (state.velocity[lower] - state.velocity[upper]) * model_->k
                                  : state.moved[lower] - state.moved[upper];
}

/// The motion that `state.change` makes, whatever forces are in it by now.
double Couplings::motion(const NetworkState& state, std::size_t c) const noexcept {
  const int lower = lower_[c], upper = upper_[c];
  if (method_ == Method::Exact) return state.change[at(lower)] - state.change[at(upper)];
  const auto bend = [&](int slot) {
    const bool force = method_ == Method::Pushed && model_->is_mass(slot);
    return state.change[at(slot)] * (force ? model_->scale[at(slot)] : 1.0);
  };
  return 2.0 * (state.moved[at(lower)] - state.moved[at(upper)]) + bend(lower) - bend(upper);
}

/// What the forces that were found so far take off the motion of a coupling.
double Couplings::pushed(const NetworkState& state, std::size_t c) const noexcept {
  double sum = 0.0;
  for (const auto& touch : state.touching) sum += mutual(c, at(touch.coupling)) * touch.force;
  return sum;
}
double Couplings::rubbed(const NetworkState& state, std::size_t c) const noexcept {
  double sum = 0.0;
  for (std::size_t f = 0; f < frictions(); ++f) sum += mutual(c, first_friction() + f) * state.rub[f];
  return sum;
}

void Couplings::store_energy(NetworkState& state) const noexcept {
  const auto apart = [&](std::size_t c) {
    const double now = state.position[at(lower_[c])] - state.position[at(upper_[c])];
    return method_ == Method::Exact ? now : now - 0.5 * moved(state, c);
  };
  const auto contacts = model_->contacts.size();
  for (std::size_t c = 0; c < contacts; ++c) {
    const auto& contact = model_->contacts[c];
    const double n = apart(c) + contact.offset;
    state.root[c] = n > 0.0 ? contact.law.root(n) : 0.0;
  }
  for (std::size_t b = 0; b < model_->bonds.size(); ++b)
    if (state.slipped[b] == 0.0) state.root[contacts + b] = model_->bonds[b].law->root(apart(contacts + b));
}

void Couplings::solve(NetworkState& state) const noexcept {
  state.touching.clear();
  if (method_ == Method::Pushed) {
    push_contacts(state);
    find_bonds(state);
  } else {
    find_contacts(state);
    find_bonds(state);
  }
  if (frictions() == 0) return solve_contacts(state);
  std::fill(state.rub.begin(), state.rub.end(), 0.0);
  for (int round = 0; round < kMostRounds; ++round) {
    solve_contacts(state);
    const double left = solve_frictions(state);
    if (alone_ || left == 0.0) return;
  }
  solve_contacts(state);
}

/// One friction after the other, each with what the others do by now. Gives how much the forces changed, 0 if
/// that no longer matters.
double Couplings::solve_frictions(NetworkState& state) const noexcept {
  constexpr double kEnough = 1e-14;
  double most = 0.0, changed = 0.0;
  for (std::size_t f = 0; f < frictions(); ++f) {
    const auto c = first_friction() + f;
    const auto& friction = model_->frictions[f];
    const double own = mutual(c, c), before = state.rub[f];
    const double free = motion(state, c) - pushed(state, c) - (rubbed(state, c) - own * before);
    const auto found =
        solve_friction(friction.law, friction.viscous, state.normal[f], free / slack(), own / slack(),
                       static_cast<int>(state.sliding[f]), 0.5 * moved(state, c) / model_->k);
    state.rub[f] = found.force;
    state.slide[f] = found.velocity;
    most = std::max(most, std::abs(found.force));
    changed = std::max(changed, std::abs(found.force - before));
  }
  return changed <= kEnough * most ? 0.0 : changed;
}

void Couplings::move(NetworkState& state) const noexcept {
  const auto masses = model_->mass.size();
  const auto add = [&](std::size_t coupling, double force) {
    const double* column = columns_.data() + coupling * masses;
    for (std::size_t i = 0; i < masses; ++i) state.change[i] -= column[i] * force;
  };
  for (const auto& touch : state.touching) add(at(touch.coupling), touch.force);
  for (std::size_t f = 0; f < frictions(); ++f) add(first_friction() + f, state.rub[f]);
}

void Couplings::finish(NetworkState& state) const noexcept {
  const auto contacts = model_->contacts.size();
  for (auto& touch : state.touching) {
    const auto c = at(touch.coupling);
    if (method_ == Method::Pushed) continue;
    touch.motion = motion(state, c);
    state.root[c] += touch.slope * touch.motion / steps();
  }
  for (std::size_t b = 0; b < model_->bonds.size(); ++b) {
    const auto& bond = model_->bonds[b];
    double& psi = state.root[contacts + b];
    const double n = indentation(state, contacts + b);
    if (state.slipped[b] != 0.0 || std::abs(bond.law->root_slope(n) * psi) <= bond.limit) continue;
    state.slipped[b] = n < 0.0 ? -1.0 : 1.0;
    if (state.audit) state.dissipated += 0.5 * psi * psi;
    psi = 0.0;
  }
  for (std::size_t f = 0; f < frictions(); ++f)
    state.sliding[f] = state.slide[f] > 0.0 ? 1.0 : state.slide[f] < 0.0 ? -1.0 : 0.0;
}

void watch_touch(const NetworkModel& model, NetworkState& state, std::size_t contact, double n,
                 double motion) noexcept {
  // Slower touches would ask for an endless loss; at 0.1 mm/s nothing is heard or felt any more.
  constexpr double kSlowest = 1e-4;
  const double loss_speed = model.contacts[contact].loss_speed;
  if (loss_speed > 0.0 && n <= motion)
    state.loss[contact] = loss_speed / std::max(motion / model.k, kSlowest);
}

}  // namespace tactus
