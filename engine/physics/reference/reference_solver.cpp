#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/core/find_root.h"
#include "engine/core/index.h"
#include "engine/core/matrix2.h"
#include "engine/physics/change_over.h"
#include "engine/physics/numbers.h"
#include "engine/physics/solvers/network_solver.h"

namespace tactus {
namespace {

// Its exponential then takes a second; larger ones are integrated faster than multiplied.
constexpr std::size_t kMostExactNumbers = 256;
// Beside it the rest lengths of springs are lost, and not the digits of a weak damper.
constexpr double kLarge = 0x1p200;
// Local error, relative to the largest position, velocity or current.
constexpr double kTolerance = 1e-13;
// A driven point changes its speed from frame to frame; less than this is rounding. [m/s]
constexpr double kStill = 1e-12;
// How far past a stop the law goes on. [m/s]
constexpr double kPast = 1e-3;
// More in one step of the network: the motion cannot be followed.
constexpr int kMostSteps = 200'000;
// Of a step of the network: what is left of it is nothing.
constexpr double kNothing = 1e-13;
// Of a step: how closely an event is located.
constexpr double kInstant = 1e-14;
// Slower motion, nearer to 0, is as good as rest. [m], [m/s], [A]
constexpr double kLeastPosition = 1e-9, kLeastVelocity = 1e-6, kLeastCurrent = 1e-9;
// So many times the tolerance may be the rounding of large forces that balance.
constexpr double kMostRounding = 1e4;

Eigen::Index row_of(std::size_t i) { return static_cast<Eigen::Index>(i); }

double largest(const double* numbers, std::size_t count) {
  double most = 0.0;
  for (std::size_t i = 0; i < count; ++i)
    if (!(std::abs(numbers[i]) <= most)) most = std::abs(numbers[i]);  // NaN is the largest
  return most;
}

double direction_of(double x) { return x > 0.0 ? 1.0 : -1.0; }

/// A force that pushes `lower` down and `upper` up.
template <class Link>
void push(double* force, const Link& link, double by) {
  force[link.lower] -= by;
  force[link.upper] += by;
}

/// The same along a direction, between bodies of several axes.
template <class Link>
void push_along(double* force, const Link& link, const Direction& along, double by) {
  for (int a = 0; a < link.axes; ++a) {
    force[link.lower + a] -= by * along[index(a)];
    force[link.upper + a] += by * along[index(a)];
  }
}

/// The loss of a contact that closes at a speed.
double start_loss(const NetworkModel::Contact& contact, double speed) {
  constexpr double kSlowest_m_per_s = 1e-4;
  if (contact.loss_speed == 0.0) return contact.loss;
  return contact.loss_speed / std::max(speed, kSlowest_m_per_s);
}

/// One step of y' = f(t, y) by the midpoint rule in 2, 4, 6, ... 16 parts, extrapolated to parts of no
/// length:
///     z_1 = y + h f(0, y),  z_m+1 = z_m-1 + 2h f(m h, z_m),  T_j1 = z_2j,  h = H / 2j
///     T_jk = T_j,k-1 + (T_j,k-1 - T_j-1,k-1) / ((j / (j-k+1))^2 - 1)
/// The result T_jj is of order 2j; |T_jj - T_j,j-1| estimates its error. Nothing of it is shared with the
/// solvers that networks are stepped with. Gragg, SIAM J. Numer. Anal. 2, 1965; Hairer, Norsett & Wanner,
/// Solving Ordinary Differential Equations I, II.9.
class Extrapolation {
 public:
  static constexpr std::size_t kColumns = 8;

  /// What came of a step that was tried.
  struct Outcome {
    bool good = false;     ///< the error is tolerated
    double error = 0;      ///< in units of what is tolerated
    double advised_s = 0;  ///< length of the next step, or of the next try
  };

  /// [control] For so many unknowns.
  explicit Extrapolation(std::size_t unknowns = 0)
      : size_(unknowns), start_(unknowns), before_(unknowns), now_(unknowns), slope_(unknowns) {
    for (auto& row : row_) row.resize(unknowns);
  }

  /// [any] `rates(t, y, slope)` with t from the start of the step; `error(y, difference)` in units of what is
  /// tolerated. The result is in `result()`.
  template <class Rates, class Error>
  Outcome step(const Rates& rates, const double* y, double seconds, const Error& error) {
    double last = 0;
    rates(0.0, y, start_.data());
    for (std::size_t j = 0; j < kColumns; ++j) {
      midpoint(rates, y, seconds, 2 * (j + 1));
      extrapolate(j);
      if (j < 2) continue;
      last = error(row_[j].data(), slope_.data());
      if (last <= 1.0) return {true, last, seconds * advice(last, j)};
    }
    return {false, last, seconds * (last == last ? std::min(0.7, advice(last, kColumns - 1)) : 0.1)};
  }

  /// [any] After a step that was good.
  const std::vector<double>& result() const { return row_[columns_ - 1]; }

 private:
  /// The error grows with the (2j - 1)-th power of the step.
  static double advice(double error, std::size_t j) {
    return std::clamp(0.8 * std::pow(std::max(error, 1e-30), -1.0 / static_cast<double>(2 * j + 1)), 0.1,
                      4.0);
  }

  template <class Rates>
  void midpoint(const Rates& rates, const double* y, double seconds, std::size_t parts) {
    const double h = seconds / static_cast<double>(parts);
    for (std::size_t i = 0; i < size_; ++i) {
      before_[i] = y[i];
      now_[i] = y[i] + h * start_[i];
    }
    for (std::size_t m = 1; m < parts; ++m) {
      rates(h * static_cast<double>(m), now_.data(), slope_.data());
      for (std::size_t i = 0; i < size_; ++i) before_[i] += 2.0 * h * slope_[i];
      before_.swap(now_);
    }
  }

  /// Turns the row T_j-1,1 ... T_j-1,j-1 into the next one; the last difference is left in `slope_`.
  void extrapolate(std::size_t j) {
    row_[j].swap(now_);
    for (std::size_t i = 0; i < size_; ++i) {
      double carry = row_[j][i];
      for (std::size_t k = 0; k < j; ++k) {
        const double ratio = static_cast<double>(j + 1) / static_cast<double>(j - k);
        const double old = row_[k][i];
        row_[k][i] = carry;
        slope_[i] = (carry - old) / (ratio * ratio - 1.0);
        carry += slope_[i];
      }
      row_[j][i] = carry;
    }
    columns_ = j + 1;
  }

  std::size_t size_;
  std::vector<double> start_, before_, now_, slope_;
  std::array<std::vector<double>, kColumns> row_;
  std::size_t columns_ = 1;
};

/// The equation of motion and its solution over one step of the network. Its numbers `y` are the positions
/// and the velocities of all slots, then the currents.
class Motion {
 public:
  explicit Motion(const NetworkModel& model) : model_(model), inverse_mass_(points()) {
    std::transform(model.mass.begin(), model.mass.end(), inverse_mass_.begin(),
                   [](double m) { return 1.0 / m; });
    numbers_.resize(2 * points() + model.coils.size());
    next_ = slope_ = numbers_;
    contacts_.resize(model.contacts.size());
    hold_.resize(model.frictions.size());
    mutual_.resize(model.frictions.size() * model.frictions.size());
    inputs_.resize(model.forces.size() + model.coils.size() + model.ports.size() + model.frictions.size() +
                   1);
    make_change();
    if (!exact()) extrapolation_ = Extrapolation(numbers_.size());
  }

  void advance(NetworkState& state) {
    load(state);
    for (std::size_t i = 0; i < model_.motions.size(); ++i) {
      const auto slot = index(model_.motions[i].on);
      numbers_[points() + slot] = (state.next[i] - numbers_[slot]) / model_.k;
    }
    exact() ? multiply() : integrate();
    for (std::size_t i = 0; i < model_.motions.size(); ++i)
      numbers_[index(model_.motions[i].on)] = state.next[i];
    store(state);
  }

  /// Forgets how long the last steps were.
  void restart() { step_s_ = 0.0; }
  bool exact() const { return change_.size() > 0; }

 private:
  enum class ContactState { Open, Pressing, Releasing };

  std::size_t points() const { return model_.start_position.size(); }
  std::size_t frictions() const { return model_.frictions.size(); }
  const double* velocities(const double* y) const { return y + points(); }

  /// Which contacts press follows from how deep they are and how fast that changes.
  void load(NetworkState& state) {
    loss_ = state.loss.data(), slide_ = state.sliding.data(), slipped_ = state.slipped.data();
    const auto copy = [](std::vector<double>& into, std::initializer_list<const AlignedNumbers*> lists) {
      auto to = into.begin();
      for (const auto* list : lists) to = std::copy(list->begin(), list->end(), to);
    };
    copy(numbers_, {&state.position, &state.velocity, &state.current});
    copy(inputs_, {&state.force, &state.voltage, &state.wave, &state.normal});
    inputs_.back() = 1.0;
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const bool pulls = 1.0 + loss_[c] * approach(numbers_.data(), c) < 0.0;
      contacts_[c] = !(indentation(numbers_, model_.contacts[c]) > 0.0) ? ContactState::Open
                     : pulls                                            ? ContactState::Releasing
                                                                        : ContactState::Pressing;
    }
  }

  void store(NetworkState& state) const {
    const double* y = numbers_.data();
    for (std::size_t i = 0; i < points(); ++i) state.change[i] = y[i] - state.position[i];
    std::copy_n(y, points(), state.position.begin());
    std::copy_n(velocities(y), points(), state.velocity.begin());
    for (std::size_t i = 0; i < state.current.size(); ++i)
      state.current[i] = state.mean_current[i] = current(y, i);
    for (std::size_t f = 0; f < frictions(); ++f) {
      // Of one that holds: the force at the end of the last step.
      state.friction_force[f] = slide_[f] == 0.0 ? hold_[f] : sliding_force(y, f, slide_[f]);
      state.friction_velocity[f] = between(velocities(y), model_.frictions[f]);
    }
    for (std::size_t b = 0; b < model_.bonds.size(); ++b)
      state.root[model_.contacts.size() + b] =
          model_.bonds[b].law->root(stretch(state.position, model_.bonds[b]));
    model_.send_waves(state, [&](int slot) { return state.change[index(slot)]; });
  }

  double approach(const double* y, std::size_t contact) const {
    return between(velocities(y), model_.contacts[contact]);
  }

  /// Without an inductance the current follows the voltage at once.
  double current(const double* y, std::size_t coil) const {
    const auto& c = model_.coils[coil];
    if (c.inductance > 0.0) return y[2 * points() + coil];
    const double* v = velocities(y);
    return (inputs_[model_.forces.size() + coil] - c.force_factor * (v[c.on] - v[c.against])) / c.resistance;
  }

  double tension(const double* y, const Spring& spring) const {
    return spring.stiffness * extension(y, spring) + spring.damping * span(velocities(y), spring);
  }

  /// K n^a with its loss, with its sign changed below 0: smooth there, as a step that runs past an opening
  /// needs.
  double pressure(const double* y, std::size_t contact) const {
    if (contacts_[contact] != ContactState::Pressing) return 0.0;
    const auto& c = model_.contacts[contact];
    const double n = indentation(y, c);
    return (n < 0.0 ? -c.law.force(-n) : c.law.force(n)) * (1.0 + loss_[contact] * approach(y, contact));
  }

  double normal(const double* y, std::size_t friction) const {
    const auto& f = model_.frictions[friction];
    const double force = f.normal_contact >= 0  ? pressure(y, index(f.normal_contact))
                         : f.normal_spring >= 0 ? tension(y, model_.springs[index(f.normal_spring)])
                                                : inputs_[inputs_.size() - 1 - frictions() + friction];
    return std::max(0.0, force);
  }

  double sliding_force(const double* y, std::size_t friction, double sign) const {
    const auto& f = model_.frictions[friction];
    const double v = between(velocities(y), f);
    return sign * normal(y, friction) * f.law.coefficient(std::max(sign * v, -kPast)) + f.viscous * v;
  }

  void rates(const double* y, double* slope) {
    double* force = slope + points();
    std::copy_n(velocities(y), points(), slope);
    std::fill_n(force, points(), 0.0);
    for (const auto& spring : model_.springs) {
      const double pull = tension(y, spring);
      if (spring.axes == 1)
        push(force, spring, -pull);
      else
        push_along(force, spring, spring.along, -pull);
    }
    for (std::size_t c = 0; c < contacts_.size(); ++c) push(force, model_.contacts[c], pressure(y, c));
    add_held(y, force);
    add_coils(y, slope);
    add_slides(y, force);
    hold(force);
    for (std::size_t i = 0; i < points(); ++i) force[i] *= inverse_mass_[i];
  }

  /// What is held over a frame: forces, and waves with the impedance of their ports.
  void add_held(const double* y, double* force) const {
    const double* held = inputs_.data();
    for (const auto& applied : model_.forces) force[applied.on] += *held++;
    held += model_.coils.size();
    for (const auto& port : model_.ports)
      force[port.on] += 2.0 * *held++ - port.impedance * velocities(y)[port.on];
  }

  void add_coils(const double* y, double* slope) const {
    const double *v = velocities(y), *voltages = inputs_.data() + model_.forces.size();
    double* force = slope + points();
    for (std::size_t i = 0; i < model_.coils.size(); ++i) {
      const auto& coil = model_.coils[i];
      const double flows = current(y, i);
      force[coil.on] += coil.force_factor * flows;
      force[coil.against] -= coil.force_factor * flows;
      const double back = coil.force_factor * (v[coil.on] - v[coil.against]);
      slope[2 * points() + i] =
          coil.inductance > 0.0 ? (voltages[i] - coil.resistance * flows - back) / coil.inductance : 0.0;
    }
  }

  void add_slides(const double* y, double* force) const {
    for (std::size_t f = 0; f < frictions(); ++f)
      if (slide_[f] != 0.0) push(force, model_.frictions[f], sliding_force(y, f, slide_[f]));
    for (std::size_t b = 0; b < model_.bonds.size(); ++b) {
      const auto& bond = model_.bonds[b];
      if (bond.axes > 1) {
        const auto along = unit(apart(y, bond));
        const double rate = dot(along, apart(velocities(y), bond));
        push_along(force, bond, along, bond.law->force(stretch(y, bond)) + bond.damping * rate);
      } else if (slipped_[b] == 0.0) {
        push(force, bond, bond.law->force(between(y, bond)) + bond.damping * between(velocities(y), bond));
      }
    }
  }

  /// Adds the forces of the frictions that hold to those of all others: (x_lower - x_upper)'' = 0.
  void hold(double* force) {
    const auto n = frictions();
    const auto& frictions = model_.frictions;
    for (std::size_t i = 0; i < n; ++i) {
      const auto& a = frictions[i];
      const bool holds = slide_[i] == 0.0;
      hold_[i] = holds ? force[a.lower] * inverse_mass_[index(a.lower)] -
                             force[a.upper] * inverse_mass_[index(a.upper)]
                       : 0.0;
      for (std::size_t j = 0; j < n; ++j) {
        const auto& b = frictions[j];
        const auto share = [&](int of_a, int of_b) {
          return of_a == of_b ? inverse_mass_[index(of_a)] : 0.0;
        };
        const double mutual = share(a.lower, b.lower) + share(a.upper, b.upper) - share(a.lower, b.upper) -
                              share(a.upper, b.lower);
        mutual_[i * n + j] = holds && slide_[j] == 0.0 ? mutual : 0.0;
      }
    }
    solve_symmetric(mutual_.data(), hold_.data(), n);
    for (std::size_t i = 0; i < n; ++i) push(force, frictions[i], hold_[i]);
  }

  /// The columns of A are the rates of unit vectors. Velocities are counted in units that make the fastest
  /// frequency 1, or the exponential would lose digits to large entries.
  void make_change() {
    const auto numbers = numbers_.size(), all = numbers + inputs_.size();
    const bool linear = model_.contacts.empty() && model_.frictions.empty() && model_.bonds.empty();
    if (!linear || all > kMostExactNumbers) return;
    double fastest = 1.0;
    for (const auto& s : model_.springs)
      for (const int end : {s.lower, s.upper})
        fastest = std::fmax(fastest, std::sqrt(s.stiffness * inverse_mass_[index(end)]));
    Eigen::VectorXd unit = Eigen::VectorXd::Ones(row_of(all));
    unit.segment(row_of(points()), row_of(points())).setConstant(fastest);

    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(row_of(all), row_of(all));
    Eigen::VectorXd constant(row_of(numbers)), column(row_of(numbers));
    rates(numbers_.data(), constant.data());
    for (std::size_t j = 0; j + 1 < all; ++j) {
      double& one = j < numbers ? numbers_[j] : inputs_[j - numbers];
      one = kLarge;
      rates(numbers_.data(), column.data());
      one = 0.0;
      a.col(row_of(j)).head(row_of(numbers)) = (column - constant) / kLarge;
    }
    a.col(row_of(all - 1)).head(row_of(numbers)) = constant;
    const Eigen::MatrixXd scaled =
        model_.k * (unit.cwiseInverse().asDiagonal() * a * unit.asDiagonal()).eval();
    change_ =
        (unit.asDiagonal() * change_over(scaled) * unit.cwiseInverse().asDiagonal()).topRows(row_of(numbers));
  }

  void multiply() {
    using Vector = Eigen::Map<Eigen::VectorXd>;
    Vector y(numbers_.data(), row_of(numbers_.size())), inputs(inputs_.data(), row_of(inputs_.size()));
    Vector next(next_.data(), y.size());
    next.noalias() = change_.leftCols(y.size()) * y;
    next.noalias() += change_.rightCols(inputs.size()) * inputs;
    y += next;
  }

  void integrate() {
    double left_s = model_.k;
    start_slides();
    for (int steps = 0; left_s > kNothing * model_.k; ++steps) {
      double done_s = steps < kMostSteps ? try_step(left_s) : 0.0;
      if (done_s == 0.0)
        return std::fill(numbers_.begin(), numbers_.end(), std::numeric_limits<double>::quiet_NaN());
      done_s = until_event(until_turn(done_s));
      numbers_.swap(next_);
      left_s -= done_s;
      switch_over();
    }
  }

  /// At the start of a frame driven points have new speeds, which what held to them or slid on them has not.
  void start_slides() {
    for (std::size_t f = 0; f < frictions(); ++f) {
      const double v = between(velocities(numbers_.data()), model_.frictions[f]);
      if (std::abs(v) > kStill) slide_[f] = direction_of(v);
    }
  }

  Extrapolation::Outcome attempt(double seconds) {
    const auto outcome = extrapolation_.step(
        [&](double, const double* y, double* slope) { rates(y, slope); }, numbers_.data(), seconds,
        [&](const double* y, const double* difference) { return error(y, difference); });
    next_ = extrapolation_.result();
    return outcome;
  }

  /// The longest step that is good and not longer than `longest_s`, into `next_`; 0: there is none.
  double try_step(double longest_s) {
    double seconds = step_s_ > 0.0 ? std::min(step_s_, longest_s) : longest_s;
    const double wanted_s = step_s_;
    double last_s = 0.0, last_error = 0.0;
    while (seconds > kNothing * kNothing * model_.k) {
      const auto outcome = attempt(seconds);
      step_s_ = outcome.advised_s;
      // What shrinks no faster than the step is no error of the method.
      const bool rounding = outcome.error < kMostRounding &&
                            outcome.error * last_s > 0.5 * last_error * seconds && last_s > 0.0;
      if (outcome.good || rounding) {
        // The end of a frame does not limit the next step.
        if (seconds == longest_s) step_s_ = std::max(step_s_, wanted_s);
        return seconds;
      }
      last_s = std::exchange(seconds, outcome.advised_s);
      last_error = outcome.error;
    }
    return 0.0;
  }

  double error(const double* y, const double* difference) const {
    double most = 0.0;
    const auto compare = [&](std::size_t from, std::size_t count, double least) {
      const double wrong = largest(difference + from, count);
      if (wrong == 0.0) return;
      const double share = wrong / (kTolerance * std::max(least, largest(y + from, count)));
      if (!(share <= most)) most = share;
    };
    compare(0, points(), kLeastPosition);
    compare(points(), points(), kLeastVelocity);
    compare(2 * points(), model_.coils.size(), kLeastCurrent);
    return most;
  }

  // What falls below 0 where a contact, a friction or a bond changes its state.

  double contact_margin(const double* y, std::size_t contact) const {
    const double n = indentation(y, model_.contacts[contact]);
    if (contacts_[contact] == ContactState::Open) return -n;
    const double push = 1.0 + loss_[contact] * approach(y, contact);
    return std::min(n, contacts_[contact] == ContactState::Pressing ? push : -push);
  }

  double friction_margin(const double* y, std::size_t friction) {
    const auto& f = model_.frictions[friction];
    if (slide_[friction] != 0.0) return slide_[friction] * between(velocities(y), f);
    rates(y, slope_.data());
    return normal(y, friction) * f.law.holding() - std::abs(hold_[friction]);
  }

  double bond_margin(const double* y, std::size_t bond) const {
    const auto& b = model_.bonds[bond];
    const double n = stretch(y, b);
    return slipped_[bond] == 0.0 ? b.law->distance_at(b.limit) - std::abs(n) : slipped_[bond] * n;
  }

  double least_margin(const double* y) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < contacts_.size(); ++c) least = std::min(least, contact_margin(y, c));
    for (std::size_t f = 0; f < frictions(); ++f) least = std::min(least, friction_margin(y, f));
    for (std::size_t b = 0; b < model_.bonds.size(); ++b) least = std::min(least, bond_margin(y, b));
    return least;
  }

  /// Cuts the step to `next_` just behind the place where `f` of its end, positive at the start, falls below
  /// 0.
  template <class Function>
  double cut(double seconds, double at_start, const Function& f) {
    const double at_end = f(next_.data());
    const auto at = [&](double time) {
      if (time <= 0.0) return at_start;
      if (time == seconds) return at_end;
      attempt(time);
      const double value = f(next_.data());
      return value == 0.0 ? std::numeric_limits<double>::min() : value;  // not yet behind it
    };
    const auto found = find_zero(at, 0.0, seconds, kInstant * seconds);
    const double behind = found.f_near < 0.0 ? found.near : found.far;
    attempt(behind);
    return behind;
  }

  /// Cuts the step to `next_` behind the first event in it.
  double until_event(double seconds) {
    if (!(least_margin(next_.data()) < 0.0)) return seconds;
    return cut(seconds, std::numeric_limits<double>::min(), [&](const double* y) { return least_margin(y); });
  }

  /// A contact may close or open and be back within a step: then its motion turns in the step.
  bool turns(double seconds, std::size_t contact) const {
    const double before = approach(numbers_.data(), contact), after = approach(next_.data(), contact);
    const bool open = contacts_[contact] == ContactState::Open;
    if (open ? !(before > 0.0 && after < 0.0) : !(before < 0.0 && after > 0.0)) return false;
    const double far = std::abs(indentation(numbers_, model_.contacts[contact]));
    return far < 2.0 * seconds * std::max(std::abs(before), std::abs(after));
  }

  /// Cuts the step to `next_` where such a motion turns, so that the deepest point is the end of a step.
  double until_turn(double seconds) {
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      if (!turns(seconds, c)) continue;
      const double before = approach(numbers_.data(), c), sign = direction_of(before);
      seconds = cut(seconds, std::abs(before), [&](const double* y) { return sign * approach(y, c); });
    }
    return seconds;
  }

  void switch_over() {
    const double* y = numbers_.data();
    for (std::size_t c = 0; c < contacts_.size(); ++c)
      if (contact_margin(y, c) < 0.0) switch_contact(c);
    for (std::size_t b = 0; b < model_.bonds.size(); ++b)
      if (bond_margin(y, b) < 0.0)
        slipped_[b] = slipped_[b] != 0.0 ? 0.0 : direction_of(between(y, model_.bonds[b]));
    for (std::size_t f = 0; f < frictions(); ++f)
      if (friction_margin(y, f) < 0.0) switch_friction(f);
  }

  void switch_contact(std::size_t contact) {
    const auto& c = model_.contacts[contact];
    auto& state = contacts_[contact];
    if (state == ContactState::Open) loss_[contact] = start_loss(c, approach(numbers_.data(), contact));
    if (indentation(numbers_, c) < 0.0)
      state = ContactState::Open;
    else
      state = state == ContactState::Pressing ? ContactState::Releasing : ContactState::Pressing;
  }

  /// One that slid has stopped: it holds if it can. One that cannot hold any longer slides.
  void switch_friction(std::size_t friction) {
    halt(model_.frictions[friction]);
    slide_[friction] = 0.0;
    if (friction_margin(numbers_.data(), friction) < 0.0) slide_[friction] = direction_of(hold_[friction]);
  }

  /// Takes away what rounding has left of the velocity at a stop.
  void halt(const Friction& friction) {
    const auto lower = index(friction.lower), upper = index(friction.upper);
    double* v = numbers_.data() + points();
    const double slides = v[lower] - v[upper], light = inverse_mass_[lower] + inverse_mass_[upper];
    if (light == 0.0) return;
    v[lower] -= slides * inverse_mass_[lower] / light;
    v[upper] += slides * inverse_mass_[upper] / light;
  }

  const NetworkModel& model_;
  std::vector<double> inverse_mass_;    ///< of each slot; 0: not moved by forces
  Eigen::MatrixXd change_;              ///< in a step, by the numbers and the inputs
  std::vector<double> numbers_, next_;  ///< y at the start and at the end of a step
  std::vector<double> slope_;           ///< workspace
  std::vector<ContactState> contacts_;
  double *loss_ = nullptr, *slide_ = nullptr,
         *slipped_ = nullptr;          ///< of contacts, frictions and bonds: the state's
  std::vector<double> inputs_;         ///< of the frame: forces, voltages, waves, normal forces, and 1
  std::vector<double> hold_, mutual_;  ///< forces of the frictions that hold, and the matrix for them
  double step_s_ = 0.0;                ///< what the last step advises
  Extrapolation extrapolation_;
};

class ReferenceSolver final : public NetworkSolver {
 public:
  explicit ReferenceSolver(const NetworkModel& model)
      : model_(model), motion_(std::make_unique<Motion>(model)) {}

  void start(NetworkState& state) const noexcept override {
    std::copy(model_.start_velocity.begin(), model_.start_velocity.end(), state.velocity.begin());
    for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
      const auto& contact = model_.contacts[c];
      const bool closed = indentation(state.position, contact) > 0.0;
      state.loss[c] = closed ? start_loss(contact, between(state.velocity, contact)) : 0.0;
    }
    motion_->restart();
  }
  void store_energy(NetworkState&) const noexcept override {}
  void step(NetworkState& state) const noexcept override { motion_->advance(state); }

  double energy(const NetworkState& state) const noexcept override {
    double sum = model_.linear_energy(state);
    for (const auto& contact : model_.contacts)
      if (const double n = indentation(state.position, contact); n > 0.0) sum += contact.law.energy(n);
    for (std::size_t b = 0; b < model_.bonds.size(); ++b)
      if (state.slipped[b] == 0.0)
        sum += model_.bonds[b].law->energy(stretch(state.position, model_.bonds[b]));
    return model_.with_inductances(sum, state);
  }

  double current(const NetworkState& state, int coil) const noexcept override {
    return state.current[index(coil)];
  }
  bool centred() const override { return false; }
  /// Beyond any that is stepped: nothing chooses it. By the exponential there are no contacts.
  Cost cost() const override { return {1e12, motion_->exact() ? 0.0 : 1e12}; }

 private:
  const NetworkModel& model_;
  std::unique_ptr<Motion> motion_;  ///< workspace: each call fills it from the state of the network
};

}  // namespace

std::unique_ptr<NetworkSolver> make_reference_solver(const NetworkModel& model) {
  return std::make_unique<ReferenceSolver>(model);
}

}  // namespace tactus
