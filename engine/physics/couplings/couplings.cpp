#include "engine/physics/couplings/couplings.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "engine/core/index.h"

namespace tactus {
namespace {

// Most numbers stored for how each coupling acts on each other and on every mass.
constexpr std::size_t kMostNumbers = 8'000'000;

// Rounds between contacts and frictions that act on each other; few are ever needed.
constexpr int kMostRounds = 60;

// Energy below 1e-24 J that is left after parting: forgotten, so that the contact costs nothing while open.
constexpr double kForgotten = 1e-12;

// What a contact has left, over what its bodies' motion holds, is given back in one step up to this; from a
// motion that is nearly rest in several. Beyond, the forces of contacts that share masses would be lost in
// rounding.
constexpr double kMostReturned = 1e6;

/// L L^T x = b for the first `n` rows of 1 + a positive semidefinite matrix; `matrix` is overwritten. Its
/// pivots are at least 1 but for rounding.
void solve_cholesky(double* matrix, double* b, std::size_t n) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = matrix[i * n + j];
      for (std::size_t l = 0; l < j; ++l) sum -= matrix[i * n + l] * matrix[j * n + l];
      matrix[i * n + j] = i == j ? std::sqrt(std::max(1.0, sum)) : sum / matrix[j * n + j];
    }
    for (std::size_t j = 0; j < i; ++j) b[i] -= matrix[i * n + j] * b[j];
    b[i] /= matrix[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    b[i] /= matrix[i * n + i];
    for (std::size_t j = 0; j < i; ++j) b[j] -= matrix[i * n + j] * b[i];
  }
}

/// y += by x
void add_row(double* y, const double* x, double by, std::size_t count) noexcept {
  for_all(count, [=]<class Vector>(std::size_t i) {
    if constexpr (std::is_same_v<Vector, double>)
      y[i] += by * x[i];
    else
      store(load<Vector>(y + i) + Vector::broadcast(by) * load<Vector>(x + i), y + i);
  });
}

/// Slope of the chord of the energy's root between two indentations.
double chord(const ContactLaw& law, double n, double motion) noexcept {
  const double to = std::max(0.0, n + motion), from = std::max(0.0, n);
  if (motion == 0.0) return law.root_slope(from);
  // Where the ends lie close the middle's slope is as good, and loses no digits.
  if (std::abs(motion) <= 1e-3 * n) return law.root_slope(n + 0.5 * motion);
  return (law.root(to) - law.root(from)) / motion;
}

}  // namespace

Result<Couplings> Couplings::make(const NetworkModel& model, Method method,
                                  const std::function<void(std::span<double>)>& respond) {
  Couplings made;
  made.model_ = &model;
  made.method_ = method;
  const auto add = [&](const auto& list) {
    for (const auto& c : list) {
      int axes = 1;
      if constexpr (requires { c.axes; }) axes = c.axes;
      made.ends_.push_back({c.lower, c.upper, axes});
      made.rows_.push_back(made.row_count_);
      made.row_count_ += index(axes);
    }
  };
  add(model.contacts), add(model.bonds), add(model.frictions);
  made.lines_ = model.has_lines();
  const auto count = made.count(), rows = made.row_count_, masses = model.mass.size();
  const bool keep = method != Method::Explicit;
  made.first_row_ = keep ? 0 : rows - made.frictions();
  if (rows * (keep ? masses + 2 * rows : made.frictions()) > kMostNumbers)
    return fail(Errc::OutOfRange, {},
                std::to_string(count) + " contacts among " + std::to_string(masses) +
                    " masses are more than this solver supports",
                "use solver = \"explicit\"");
  made.mutual_.resize((rows - made.first_row_) * rows);
  made.inertia_.resize(model.bonds.size());
  if (made.mutual_.empty() && !keep) return made;
  std::vector<double> column(model.start_position.size());
  const std::span<double> on_masses{column.data(), masses};
  struct Row {
    std::size_t coupling;
    int lower, upper;
  };
  std::vector<Row> each;
  for (std::size_t c = 0; c < count; ++c)
    for (int a = 0; a < made.ends_[c].axes; ++a)
      each.push_back({c, made.ends_[c].lower + a, made.ends_[c].upper + a});
  for (std::size_t r = 0; r < rows; ++r) {
    std::fill(column.begin(), column.end(), 0.0);
    column[index(each[r].lower)] += 1.0;
    column[index(each[r].upper)] -= 1.0;
    std::fill(column.begin() + model.masses, column.end(), 0.0);
    respond(on_masses);
    if (keep) made.columns_.insert(made.columns_.end(), on_masses.begin(), on_masses.end());
    for (std::size_t row = made.first_row_; row < rows; ++row) {
      const double motion = between(column, each[row]);
      made.mutual_[(row - made.first_row_) * rows + r] = motion;
      made.alone_ = made.alone_ && (each[row].coupling == each[r].coupling || motion == 0.0);
    }
  }
  if (method != Method::Centred && method != Method::Gradient) return made;
  for (std::size_t b = 0; b < model.bonds.size(); ++b) {
    const auto c = model.contacts.size() + b;
    if (model.bonds[b].axes > 1) continue;  // a weight that turns with the line would make energy
    const double damping = model.bonds[b].damping;
    made.inertia_[b] = model.stiff_inertia(damping, damping * made.mutual(c, c) / model.k);
  }
  return made;
}

double Couplings::indentation(const NetworkState& state, std::size_t c) const noexcept {
  const double offset = c < model_->contacts.size() ? model_->contacts[c].offset : 0.0;
  return between(state.position, ends_[c]) + offset;
}

double Couplings::mutual_along(const NetworkState& state, std::size_t c, std::size_t other) const noexcept {
  double sum = 0.0;
  for (int a = 0; a < ends_[c].axes; ++a)
    for (int b = 0; b < ends_[other].axes; ++b)
      sum +=
          share(state, c, a) * share(state, other, b) * by_rows(rows_[c] + index(a), rows_[other] + index(b));
  return sum;
}

/// y = W f, with f from `force_of(link)` of all that is active along its line, and from the frictions.
template <class Force>
void Couplings::respond_to(NetworkState& state, const Force& force_of) const noexcept {
  double *f = row_force(state), *y = row_motion(state);
  std::fill_n(f, row_count_, 0.0);
  std::fill_n(y, row_count_, 0.0);
  for (const auto& link : state.active) {
    const auto c = index(link.coupling);
    for (int a = 0; a < ends_[c].axes; ++a) f[rows_[c] + index(a)] = share(state, c, a) * force_of(link);
  }
  for (std::size_t i = 0; i < frictions(); ++i) f[rows_[first_friction() + i]] = state.friction_force[i];
  for (std::size_t r = 0; r < row_count_; ++r)
    if (f[r] != 0.0) add_row(y, mutual_.data() + r * row_count_, f[r], row_count_);  // W is symmetric
}
void Couplings::respond_to_forces(NetworkState& state) const noexcept {
  respond_to(state, [](const ActiveCoupling& link) { return link.force; });
}
double Couplings::row_motion_along(NetworkState& state, std::size_t c) const noexcept {
  double sum = 0.0;
  for (int a = 0; a < ends_[c].axes; ++a) sum += share(state, c, a) * row_motion(state)[rows_[c] + index(a)];
  return sum;
}

/// The sum of `of(lower, upper)` of each axis along the direction.
template <class Part>
double Couplings::along(const NetworkState& state, std::size_t c, const Part& of) const noexcept {
  if (ends_[c].axes == 1) return of(ends_[c].lower, ends_[c].upper);
  double sum = 0.0;
  for (int a = 0; a < ends_[c].axes; ++a)
    sum += share(state, c, a) * of(ends_[c].lower + a, ends_[c].upper + a);
  return sum;
}

void Couplings::find_lines(NetworkState& state) const noexcept {
  for (std::size_t b = 0; lines_ && b < model_->bonds.size(); ++b) {
    const auto direction = unit(apart(state.position, model_->bonds[b]));
    std::copy(direction.begin(), direction.end(), state.along.begin() + std::ptrdiff_t(kMostAxes * b));
  }
}

/// How far it moved in the last step, or would in this one by its velocity alone.
double Couplings::moved(const NetworkState& state, std::size_t c) const noexcept {
  if (ends_[c].axes > 1)
    return along(state, c, [&](int lower, int upper) {
      return method_ == Method::Exact
                 ? (state.velocity[index(lower)] - state.velocity[index(upper)]) * model_->k
                 : state.moved[index(lower)] - state.moved[index(upper)];
    });
  return method_ == Method::Exact ? between(state.velocity, ends_[c]) * model_->k
                                  : between(state.moved, ends_[c]);
}

/// The motion that `state.change` makes, whatever forces are in it by now.
double Couplings::motion(const NetworkState& state, std::size_t c) const noexcept {
  return along(state, c, [&](int lower, int upper) { return axis_motion(state, lower, upper); });
}

double Couplings::axis_motion(const NetworkState& state, int lower, int upper) const noexcept {
  if (method_ == Method::Exact) return state.change[index(lower)] - state.change[index(upper)];
  const auto bend = [&](int slot) {
    const bool force = method_ == Method::Explicit && model_->is_mass(slot);
    return state.change[index(slot)] * (force ? model_->scale[index(slot)] : 1.0);
  };
  return 2.0 * (state.moved[index(lower)] - state.moved[index(upper)]) + bend(lower) - bend(upper);
}

/// What the forces that were found so far take off the motion of a coupling.
double Couplings::taken_by_contacts(const NetworkState& state, std::size_t c) const noexcept {
  double sum = 0.0;
  for (const auto& link : state.active) sum += acting(state, c, index(link.coupling)) * link.force;
  return sum;
}
double Couplings::taken_by_friction(const NetworkState& state, std::size_t c) const noexcept {
  double sum = 0.0;
  for (std::size_t f = 0; f < frictions(); ++f)
    sum += acting(state, c, first_friction() + f) * state.friction_force[f];
  return sum;
}

/// With all forces that were found so far.
double Couplings::next_motion(const NetworkState& state, const ActiveCoupling& link) const noexcept {
  const auto c = index(link.coupling);
  return link.free_motion - taken_by_friction(state, c) - taken_by_contacts(state, c);
}

void Couplings::store_energy(NetworkState& state) const noexcept {
  const auto apart = [&](std::size_t c) {
    const double now = between(state.position, ends_[c]);
    return method_ == Method::Exact ? now : now - 0.5 * moved(state, c);
  };
  const auto contacts = model_->contacts.size();
  for (std::size_t c = 0; c < contacts; ++c) {
    const auto& contact = model_->contacts[c];
    const double n = apart(c) + contact.offset;
    state.root[c] = method_ != Method::Gradient && n > 0.0 ? contact.law.root(n) : 0.0;
  }
  for (std::size_t b = 0; b < model_->bonds.size(); ++b)
    if (const auto& bond = model_->bonds[b]; bond.axes > 1)
      state.root[contacts + b] = bond.law->root(length(line_before(state, bond)) - bond.rest);
    else if (state.slipped[b] == 0.0)
      state.root[contacts + b] = bond.law->root(apart(contacts + b));
}

void Couplings::solve(NetworkState& state) const noexcept {
  state.active.clear();
  find_contacts(state);
  find_bonds(state);
  if (frictions() == 0) return solve_contacts(state);
  std::fill(state.friction_force.begin(), state.friction_force.end(), 0.0);
  // Those that held share what there is to hold before one of them slides.
  bool clings = !alone_;
  for (int round = 0; round < kMostRounds; ++round) {
    solve_contacts(state);
    const double left = solve_frictions(state, clings);
    if (alone_ || (left == 0.0 && !(clings && one_breaks(state)))) return;
    if (left == 0.0 || round == kMostRounds / 2) clings = false;
  }
  solve_contacts(state);
}

/// One friction after the other, each with what the others do by now. Gives how much the forces changed, 0 if
/// that no longer matters.
double Couplings::solve_frictions(NetworkState& state, bool clings) const noexcept {
  constexpr double kEnough = 1e-14;
  double most = 0.0, changed = 0.0;
  for (std::size_t f = 0; f < frictions(); ++f) {
    const double before = state.friction_force[f];
    solve_friction(state, f, clings);
    const double now = state.friction_force[f];
    most = std::max(most, std::abs(now));
    changed = std::max(changed, std::abs(now - before));
  }
  return changed <= kEnough * most ? 0.0 : changed;
}

void Couplings::solve_friction(NetworkState& state, std::size_t f, bool clings) const noexcept {
  const auto c = first_friction() + f;
  const auto& friction = model_->frictions[f];
  const bool centred = method_ != Method::Exact;
  const double own = mutual(c, c), jump = driven_jump(state, friction) / model_->k;
  const double taken =
      taken_by_contacts(state, c) + taken_by_friction(state, c) - own * state.friction_force[f];
  FrictionStep step{.normal = state.normal[f],
                    .free = (motion(state, c) - taken) / slack(),
                    .mobility = own / slack(),
                    .before = moved(state, c) / model_->k,
                    .jump = jump,
                    .holds = state.sliding[f] == 0.0,
                    .centred = centred,
                    .clings = clings,
                    .memory = state.friction[f]};
  if (!centred && !step.holds) step.before += jump;
  auto& found = state.rubbed[f];
  if (centred && step.memory.margin == FrictionMemory::kStart)
    found = start_friction(friction.law, friction.viscous, step,
                           between(model_->start_velocity, friction) + jump);
  else
    found = tactus::solve_friction(friction.law, friction.viscous, step);
  state.friction_force[f] = found.force;
  state.friction_velocity[f] = found.velocity;
}

/// By how much the velocity of what is driven is another one than in the last step, times k.
double Couplings::driven_jump(const NetworkState& state, const Friction& friction) const noexcept {
  const auto jump = [&](int slot) {
    if (model_->is_mass(slot) || !model_->moves(slot)) return 0.0;
    const double way = state.change[index(slot)];
    return method_ == Method::Exact ? way - model_->k * state.velocity[index(slot)] : way;
  };
  return jump(friction.lower) - jump(friction.upper);
}

/// Whether a friction that held cannot hold.
bool Couplings::one_breaks(const NetworkState& state) const noexcept {
  for (std::size_t f = 0; f < frictions(); ++f)
    if (state.sliding[f] == 0.0 && state.rubbed[f].after != 0.0) return true;
  return false;
}

void Couplings::move(NetworkState& state) const noexcept {
  const auto masses = model_->mass.size();
  const auto add = [&](std::size_t coupling, double force) {
    const double* column = columns_.data() + row_of(coupling) * masses;
    for (int a = 0; a < ends_[coupling].axes; ++a, column += masses) {
      const double part = lines_ ? share(state, coupling, a) * force : force;
      for (std::size_t i = 0; i < masses; ++i) state.change[i] -= column[i] * part;
    }
  };
  for (const auto& link : state.active) add(index(link.coupling), link.force);
  for (std::size_t f = 0; f < frictions(); ++f) add(first_friction() + f, state.friction_force[f]);
}

void Couplings::finish(NetworkState& state) const noexcept {
  const auto contacts = model_->contacts.size();
  if (method_ != Method::Explicit)
    for (auto& link : state.active) {
      link.motion = motion(state, index(link.coupling));
      state.root[index(link.coupling)] += link.slope * link.motion / steps();
    }
  if (state.let_go) lose_energy(state);
  for (std::size_t b = 0; b < model_->bonds.size(); ++b) {
    const auto& bond = model_->bonds[b];
    if (bond.axes > 1) continue;  // it never slips
    double& psi = state.root[contacts + b];
    const double n = indentation(state, contacts + b);
    if (state.slipped[b] != 0.0 || std::abs(bond.law->root_slope(n) * psi) <= bond.limit) continue;
    state.slipped[b] = n < 0.0 ? -1.0 : 1.0;
    psi = 0.0;
  }
  for (std::size_t f = 0; f < frictions(); ++f) {
    const double after = state.rubbed[f].after;
    state.sliding[f] = after > 0.0 ? 1.0 : after < 0.0 ? -1.0 : 0.0;
    state.friction[f] = state.rubbed[f].memory;
  }
}

/// Of released contacts with a loss, as far as their bodies part.
void Couplings::lose_energy(NetworkState& state) const noexcept {
  state.let_go = false;
  for (std::size_t c = 0; c < model_->contacts.size(); ++c) {
    double& psi = state.root[c];
    if (psi == 0.0 || state.loss[c] == 0.0) continue;
    const auto active = [&](const ActiveCoupling& link) { return index(link.coupling) == c; };
    const double n = indentation(state, c), apart = std::min(0.0, motion(state, c));
    if (n <= 0.0 || std::any_of(state.active.begin(), state.active.end(), active)) continue;
    const auto& law = model_->contacts[c].law;
    const double slope = method_ == Method::Exact ? chord(law, n, apart) : law.root_slope(n);
    const double left = std::max(0.0, std::abs(psi) + slope * apart / steps());
    psi = std::copysign(left, psi);
  }
}

double loss_of_strike(const NetworkModel& model, std::size_t contact, double motion) noexcept {
  // Slower impacts would need an unbounded loss; below 0.1 mm/s nothing is audible or tangible.
  constexpr double kSlowest = 1e-4;
  const auto& c = model.contacts[contact];
  return c.loss_speed > 0.0 ? c.loss_speed / std::max(motion / model.k, kSlowest) : c.loss;
}

void start_contact(const NetworkModel& model, NetworkState& state, std::size_t contact, double n,
                   double motion) noexcept {
  if (model.contacts[contact].loss_speed > 0.0 && n <= motion)
    state.loss[contact] = loss_of_strike(model, contact, motion);
}

void start_loss(const NetworkModel& model, NetworkState& state, std::size_t contact, double motion) noexcept {
  const double n = indentation(state.position, model.contacts[contact]);
  state.loss[contact] = model.contacts[contact].loss;
  if (n > 0.0) start_contact(model, state, contact, n, std::max(n, motion));
}

void Couplings::find_contacts(NetworkState& state) const noexcept {
  if (method_ == Method::Explicit) return push_contacts(state);
  for (std::size_t c = 0; c < model_->contacts.size(); ++c) {
    ActiveCoupling link{.coupling = static_cast<int>(c)};
    if (method_ != Method::Gradient) {
      if (predict(state, link)) state.active.push_back(link);
      continue;
    }
    const double w = moved(state, c);
    if (std::max(indentation(state, c), indentation(state, c) - w) <= 0.0) state.root[c] = 0.0;
    const double n = depth(state, c), before = depth_before(state, c);
    link.free_motion = motion(state, c);
    if (std::max({n, before, before + link.free_motion}) <= 0.0) continue;
    if (n >= 0.0) start_contact(*model_, state, c, n, w);
    if (n <= 0.0 && w > 0.0) bounce(link, w, loss_of_strike(*model_, c, w));
    state.active.push_back(link);
  }
}

/// The remaining energy returns to the bodies while they part; `motion` is the predicted one.
bool Couplings::release(NetworkState& state, ActiveCoupling& link, double motion) const noexcept {
  double& psi = state.root[index(link.coupling)];
  if (std::abs(psi) <= kForgotten) psi = 0.0;
  if (psi == 0.0 || motion >= -1e-30) return false;
  const double steepest = std::sqrt(kMostReturned / mutual(index(link.coupling), index(link.coupling)));
  link.slope = std::clamp(-psi / motion, -steepest, steepest);
  return true;
}

/// Whether a contact that begins lasts less than a step: then it is the damper of its restitution.
bool Couplings::bounce(ActiveCoupling& link, double approach, double loss) const noexcept {
  const auto c = index(link.coupling);
  const double own = mutual(c, c);
  if (loss == 0.0 || approach <= 0.0 || own == 0.0) return false;
  const double loss_speed = loss * approach / model_->k;
  // m v^2 of the two bodies, m = k^2 steps / 2 W.
  const double twice_kinetic = 0.5 * steps() * approach * approach / own;
  if (model_->contacts[c].law.energy(approach) <= twice_kinetic * stored_at_deepest(loss_speed)) return false;
  const double e = restitution_of(loss_speed);
  if (e >= 1.0) return false;
  link.resistance = (1.0 + e) / ((1.0 - e) * own);
  link.bounces = true;
  return true;
}

/// What the present forces take off the motion of contact c: those of the energy that is stored, which after
/// a bounce is less than the law has at this depth. A loss stops its bodies at most. A larger prediction
/// would leave a contact that is pressed with next to no slope.
double Couplings::predicted_push(const NetworkState& state, std::size_t c) const noexcept {
  double sum = 0.0;
  const auto add = [&](std::size_t other) {
    const double n = indentation(state, other);
    if (n <= 0.0) return;
    const double force = std::abs(state.root[other]) * model_->contacts[other].law.root_slope(n);
    const double w = moved(state, other), loss = force * state.loss[other] * w / model_->k;
    const double own = mutual(other, other);
    const double most = own > 0.0 ? std::abs(w) / own : std::abs(loss);
    sum += mutual(c, other) * std::max(0.0, force + std::min(loss, most));
  };
  if (alone_)
    add(c);
  else
    for (std::size_t other = 0; other < model_->contacts.size(); ++other) add(other);
  return sum;
}

/// The predicted motion: that of the last step, or, over one step, the free one less what the present forces
/// take off it.
bool Couplings::predict(NetworkState& state, ActiveCoupling& link) const noexcept {
  const auto c = index(link.coupling);
  const auto& law = model_->contacts[c].law;
  const bool exact = method_ == Method::Exact;
  const double n = indentation(state, c), psi = state.root[c], w = moved(state, c);
  if (!exact && n < 0.0 && psi == 0.0) return false;
  link.free_motion = motion(state, c);
  const double motion = exact ? link.free_motion - predicted_push(state, c) : w;
  const bool closes = exact && n + motion > 0.0;
  if (exact ? n <= 0.0 && closes : n >= 0.0) start_contact(*model_, state, c, n, w);
  double damping = 0.0;
  if (n >= 0.0 || closes) {
    if (psi == 0.0 && n <= w && bounce(link, w, state.loss[c])) return true;
    const bool first = n <= w && w > 0.0 && psi == 0.0;
    const double g = exact ? chord(law, n, motion) : first ? law.root(n + 0.5 * w) / w : law.root_slope(n);
    link.slope = psi < 0.0 ? -g : g;
    const double force = link.slope * (psi + 0.5 * link.slope * motion);
    damping = state.loss[c] * std::max(0.0, force) / slack();
  } else if (!release(state, link, motion)) {
    return false;
  }
  link.static_force = link.slope * psi;
  link.resistance = square(link.slope) / (2.0 * steps()) + damping;
  return true;
}

void Couplings::find_bonds(NetworkState& state) const noexcept {
  const auto contacts = model_->contacts.size();
  if (method_ == Method::Explicit)
    find_lines(state);
  else if (lines_)
    std::fill_n(row_motion(state), row_count_, 0.0);
  for (std::size_t b = 0; b < model_->bonds.size(); ++b) {
    const auto c = contacts + b;
    const auto& bond = model_->bonds[b];
    if (bond.axes > 1) {
      ActiveCoupling link{.coupling = static_cast<int>(c)};
      if (method_ != Method::Explicit) {
        turn_line(state, link);
      } else {
        const double n = stretch(state.position, bond);
        state.root[c] = bond.law->root(n);
        link.force = bond.law->force(n) + bond.damping * moved(state, c) / model_->k;
      }
      state.active.push_back(link);
      continue;
    }
    const double n = indentation(state, c);
    if (state.slipped[b] * n < 0.0) state.slipped[b] = state.root[c] = 0.0;
    if (state.slipped[b] != 0.0) continue;
    ActiveCoupling link{.coupling = static_cast<int>(c)};
    if (method_ == Method::Explicit) {
      state.root[c] = bond.law->root(n);
      link.force = bond.law->force(n) + bond.damping * moved(state, c) / model_->k;
    }
    link.free_motion = motion(state, c);
    update_bond(state, link, link.free_motion);
    state.active.push_back(link);
  }
}

/// The direction and the chord of a bond of several axes for the motion that the forces of
/// `respond_to_forces` cause. True if they changed.
bool Couplings::turn_line(NetworkState& state, ActiveCoupling& link) const noexcept {
  // Energy is kept whatever the direction is; each round leaves some hundredth or less of the last change.
  constexpr double kEnough = 1e-12;
  const auto c = index(link.coupling), b = c - model_->contacts.size();
  const auto& bond = model_->bonds[b];
  const auto from = line_before(state, bond);
  auto to = from;
  for (int a = 0; a < bond.axes; ++a) {
    const double free = axis_motion(state, bond.lower + a, bond.upper + a);
    to[index(a)] += (free - row_motion(state)[rows_[c] + index(a)]) / steps();
  }
  const double one = length(from), other = length(to), both = one + other;
  double turned = 0.0;
  for (std::size_t a = 0; a < from.size(); ++a) {
    const double next = both > 0.0 ? (from[a] + to[a]) / both : 0.0;
    turned = std::max(turned, std::abs(next - std::exchange(state.along[kMostAxes * b + a], next)));
  }
  const auto chord = bond.law->chord(one - bond.rest, other - bond.rest);
  const bool changed = turned > kEnough || std::abs(chord.slope - link.slope) > kEnough * chord.slope;
  link.slope = chord.slope;
  link.static_force = link.slope * state.root[c];
  link.resistance = chord.square / (2.0 * steps()) + bond.damping / slack();
  link.free_motion = motion(state, c);
  return changed;
}

/// x_lower - x_upper where psi was stored last.
Direction Couplings::line_before(const NetworkState& state, const Bond& bond) const noexcept {
  auto line = apart(state.position, bond);
  if (method_ == Method::Exact) return line;
  const auto moved = apart(state.moved, bond);
  for (std::size_t a = 0; a < line.size(); ++a) line[a] -= 0.5 * moved[a];
  return line;
}

/// Sets the chord of a bond for a motion. True if it changed.
bool Couplings::update_bond(NetworkState& state, ActiveCoupling& link, double motion) const noexcept {
  constexpr double kEnough = 1e-15;
  const auto c = index(link.coupling);
  const auto& bond = model_->bonds[c - model_->contacts.size()];
  if (bond.axes > 1) return turn_line(state, link);
  const double n = indentation(state, c), from = method_ == Method::Exact ? n : n - 0.5 * moved(state, c);
  const auto chord = bond.law->chord(from, from + motion / steps());
  const bool changed = std::abs(chord.slope - link.slope) > kEnough * chord.slope;
  link.slope = chord.slope;
  link.static_force = link.slope * state.root[c];
  link.resistance = chord.square / (2.0 * steps()) + bond.damping / slack();
  if (const double inertia = inertia_[c - model_->contacts.size()]; inertia > 0.0) {
    link.static_force -= 2.0 * inertia * moved(state, c);
    link.resistance += inertia;
  }
  return changed;
}

/// Updates the chords of all bonds to the motions that the forces cause. True if one changed.
bool Couplings::update_bonds(NetworkState& state) const noexcept {
  bool changed = false;
  if (lines_) respond_to_forces(state);
  for (auto& link : state.active) {
    const auto c = index(link.coupling), contacts = model_->contacts.size();
    if (c >= contacts && (ends_[c].axes > 1 || !model_->bonds[c - contacts].law->linear()))
      changed |= update_bond(state, link, next_motion(state, link));
  }
  return changed;
}

/// The solver of mass-interaction: from the present state.
void Couplings::push_contacts(NetworkState& state) const noexcept {
  for (std::size_t c = 0; c < model_->contacts.size(); ++c) {
    const double n = indentation(state, c);
    if (n <= 0.0) continue;
    const double motion = moved(state, c);
    start_contact(*model_, state, c, n, motion);
    const double rate = 1.0 + state.loss[c] * motion / model_->k;
    state.active.push_back(
        {.coupling = static_cast<int>(c), .force = std::max(0.0, model_->contacts[c].law.force(n) * rate)});
  }
}

void Couplings::solve_contacts(NetworkState& state) const noexcept {
  if (method_ == Method::Explicit || state.active.empty()) return;
  if (method_ != Method::Gradient) return solve_quadratised(state);
  do solve_gradient(state);
  while (!alone_ && missed_one(state));
}

/// A contact that would have to pull is released for the step. What it holds goes as the bodies part: into
/// its loss, which outweighs its push, or to the bodies where it has none. Released is, over one step, also
/// an open contact with energy left whose bodies approach without closing it: it would hold them apart in the
/// air.
void Couplings::solve_quadratised(NetworkState& state) const noexcept {
  const auto floats = [&](const ActiveCoupling& link) {
    const auto c = index(link.coupling);
    if (method_ != Method::Exact || state.root[c] == 0.0) return false;
    const double n = indentation(state, c), motion = n < 0.0 ? next_motion(state, link) : 0.0;
    return motion > 0.0 && n + motion <= 0.0;
  };
  const auto pulls = [&](const ActiveCoupling& link) {
    if (index(link.coupling) >= model_->contacts.size()) return false;
    return link.force < 0.0 || floats(link);
  };
  const auto some_pull = [&] {
    for (auto& link : state.active) link.released = pulls(link);  // each against all others
    const bool some =
        std::erase_if(state.active, [](const ActiveCoupling& link) { return link.released; }) > 0;
    state.let_go = state.let_go || some;
    return some;
  };
  constexpr int kMostChords = 30;
  for (int round = 0; round < kMostChords; ++round) {
    do {
      if (state.active.empty()) return;
      solve_linear(state);
    } while (some_pull());
    if (model_->bonds.empty() || !update_bonds(state)) return;
  }
  solve_linear(state);
}

/// Forces F = F0 + S d of all active couplings, where d = d_free - W F:  with y = sqrt(S) d,
/// (1 + sqrt(S) W sqrt(S)) y = sqrt(S) (d_free - W F0), symmetric and positive definite.
void Couplings::solve_linear(NetworkState& state) const noexcept {
  auto& active = state.active;
  const auto n = active.size();
  const auto w = [&](const ActiveCoupling& a, const ActiveCoupling& b) {
    return mutual(index(a.coupling), index(b.coupling));
  };
  if (lines_) return solve_lines(state);
  if (n == 1 || alone_) {
    for (auto& t : active) {
      const double free = t.free_motion - (alone_ ? 0.0 : taken_by_friction(state, index(t.coupling)));
      t.force = (t.static_force + t.resistance * free) / (1.0 + t.resistance * w(t, t));
    }
    return;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double root = std::sqrt(active[i].resistance);
    double free = active[i].free_motion - taken_by_friction(state, index(active[i].coupling));
    for (std::size_t j = 0; j < n; ++j) {
      const double mutual = w(active[i], active[j]);
      free -= mutual * active[j].static_force;
      state.matrix[i * n + j] = (i == j ? 1.0 : 0.0) + root * mutual * std::sqrt(active[j].resistance);
    }
    state.right[i] = root * free;
  }
  solve_cholesky(state.matrix.data(), state.right.data(), n);
  for (std::size_t i = 0; i < n; ++i)
    active[i].force = active[i].static_force + std::sqrt(active[i].resistance) * state.right[i];
}

/// The same with couplings of several rows, from the lower half of the matrix.
void Couplings::solve_lines(NetworkState& state) const noexcept {
  auto& active = state.active;
  const auto n = active.size();
  respond_to(state, [](const ActiveCoupling& link) { return link.static_force; });
  for (std::size_t i = 0; i < n; ++i) {
    const auto c = index(active[i].coupling);
    state.right[i] = std::sqrt(active[i].resistance) * (active[i].free_motion - row_motion_along(state, c));
  }
  double* row = row_force(state);
  for (std::size_t i = 0; i < n; ++i) {
    const auto c = index(active[i].coupling);
    const double root = std::sqrt(active[i].resistance);
    std::fill_n(row, row_count_, 0.0);
    for (int a = 0; a < ends_[c].axes; ++a)
      add_row(row, mutual_.data() + (rows_[c] + index(a)) * row_count_, share(state, c, a), row_count_);
    for (std::size_t j = 0; j <= i; ++j) {
      const auto other = index(active[j].coupling);
      double mutual = 0.0;
      for (int b = 0; b < ends_[other].axes; ++b)
        mutual += share(state, other, b) * row[rows_[other] + index(b)];
      state.matrix[i * n + j] = (i == j ? 1.0 : 0.0) + root * mutual * std::sqrt(active[j].resistance);
    }
  }
  solve_cholesky(state.matrix.data(), state.right.data(), n);
  for (std::size_t i = 0; i < n; ++i)
    active[i].force = active[i].static_force + std::sqrt(active[i].resistance) * state.right[i];
}

/// F and its slope at the present estimate d of the motion:  F = G(d) (1 + r d / 2k), G = (phi(n- + d) -
/// phi(n-)) / d, both convex and never below 0.
void Couplings::follow(NetworkState& state, ActiveCoupling& link) const noexcept {
  const auto c = index(link.coupling);
  if (link.bounces) return;
  if (c >= model_->contacts.size()) {
    update_bond(state, link, link.motion);
    return;
  }
  const auto& law = model_->contacts[c].law;
  const auto energy = [&](double n) { return n > 0.0 ? law.energy(n) : 0.0; };
  const auto force = [&](double n) { return n > 0.0 ? law.force(n) : 0.0; };
  const double from = depth_before(state, c), d = link.motion, to = from + d;
  double g, slope;
  if (std::abs(d) <= 1e-7 * std::abs(from)) {
    g = force(from + 0.5 * d);
    slope = from > 0.0 ? 0.5 * law.stiffness(from) : 0.0;
  } else {
    g = (energy(to) - energy(from)) / d;
    slope = (force(to) - g) / d;
  }
  const double loss = state.loss[c] / slack(), rate = std::max(0.0, 1.0 + loss * d);
  link.force = g * rate;
  link.resistance = std::max(0.0, slope * rate + (rate > 0.0 ? g * loss : 0.0));
  link.static_force = link.force - link.resistance * d;
}

/// Newton's method, from the free motion down: what is sought is the zero of a convex function of each
/// motion.
void Couplings::solve_gradient(NetworkState& state) const noexcept {
  constexpr int kMostSteps = 60;
  const double enough = lines_ ? 1e-12 : 1e-15;  // what nearly rests is rounding of forces that balance
  for (auto& link : state.active)
    link.motion = link.free_motion - taken_by_friction(state, index(link.coupling));
  double before = 1e300;
  for (int i = 0; i < kMostSteps; ++i) {
    if (lines_) respond_to_forces(state);
    for (auto& link : state.active) follow(state, link);
    solve_linear(state);
    if (lines_) respond_to_forces(state);
    double left = 0.0;
    for (auto& link : state.active) {
      const double next = lines_ ? link.free_motion - row_motion_along(state, index(link.coupling))
                                 : next_motion(state, link);
      const double by = next - link.motion;
      double scale = std::abs(next) + std::abs(link.free_motion);
      if (const auto c = index(link.coupling); ends_[c].axes > 1)  // a motion of nearly 0 is rounding
        scale += length(apart(state.position, model_->bonds[c - model_->contacts.size()]));
      left = std::max(left, std::abs(by) / scale);
      link.motion += left > before ? 0.5 * by : by;
    }
    if (!(left > enough)) break;
    before = left;
  }
}

/// Adds contacts that the active couplings close. True if there were any.
bool Couplings::missed_one(NetworkState& state) const noexcept {
  const auto found = state.active.size();
  for (std::size_t c = 0; c < model_->contacts.size(); ++c) {
    const auto known = [&](const ActiveCoupling& link) { return index(link.coupling) == c; };
    if (std::any_of(state.active.begin(), state.active.end(), known)) continue;
    const ActiveCoupling link{.coupling = static_cast<int>(c), .free_motion = motion(state, c)};
    if (depth_before(state, c) + next_motion(state, link) > 0.0) state.active.push_back(link);
  }
  return state.active.size() > found;
}

}  // namespace tactus
