#include "engine/study/work_precision/methods/methods.h"

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>

#include "engine/core/not_realtime.h"
#include "engine/study/work_precision/methods/motion.h"

namespace tactus {
namespace {

using Vector = Motion::Vector;

/// What all methods with velocities at the frames have in common.
class Method : public NetworkSolver {
 public:
  explicit Method(const NetworkModel& model) : model_(model), motion_(model) {}

  void start(NetworkState& state) const noexcept override {
    std::copy(model_.start_velocity.begin(), model_.start_velocity.end(), state.velocity.begin());
    fresh_ = true;
  }
  void store_energy(NetworkState&) const noexcept override {}
  double energy(const NetworkState& state) const noexcept override { return motion_.energy(state); }
  double current(const NetworkState& state, int coil) const noexcept override {
    return motion_.current(state, coil);
  }
  bool centred() const override { return false; }
  Cost cost() const override { return {motion_.multiplications() / std::max(1.0, steps_), 0.0}; }

  void step(NetworkState& state) const noexcept override {
    const NotRealtime allocates;
    motion_.begin(state);
    x_ = motion_.positions();
    v_ = motion_.velocities();
    advance(x_, v_);
    motion_.end(x_, v_, state);
    ++steps_;
    fresh_ = false;
  }

 protected:
  /// Over one step.
  virtual void advance(Vector& x, Vector& v) const = 0;

  const NetworkModel& model_;
  // One state uses a method at a time.
  mutable Motion motion_;
  mutable bool fresh_ = true;  ///< no step was made since the start

 private:
  mutable Vector x_, v_;
  mutable double steps_ = 0;
};

/// x+ = x + k v + k^2 a / 2,  v+ = v + k (a + a+) / 2,  a+ = M^-1 F(x+, v + k a), which is the next step's a
/// but for what enters then. Swope, Andersen, Berens & Wilson, J. Chem. Phys. 76, 1982.
class Verlet final : public Method {
 public:
  using Method::Method;

 private:
  void advance(Vector& x, Vector& v) const override {
    const double k = motion_.k();
    if (fresh_) evaluate(0.0, x, v);
    start_ = (force_ + motion_.entering()).cwiseQuotient(motion_.mass());
    x += k * v + 0.5 * k * k * start_;
    evaluate(1.0, x, v + k * start_);
    end_ = (force_ + motion_.entering()).cwiseQuotient(motion_.mass());
    v += 0.5 * k * (start_ + end_);
    motion_.count(6.0 * motion_.size());
  }
  void evaluate(double share, const Vector& x, const Vector& v) const {
    motion_.linear_force(share, x, v, force_);
    motion_.add_contacts(share, x, v, force_);
  }

  mutable Vector force_, start_, end_;
};

/// All that contacts store as one quadratised energy, psi^2 / 2 = V + eps with a slope g = grad V / psi(V):
///   M (x+ - 2 x + x-) / k^2 = F_linear - (psi+ + psi-) g / 2,   psi+ - psi- = g (x+ - x-) / 2
/// with the way of driven points in the second.
/// One division solves it, since g is a vector. psi keeps the sign that it has. The loss of contacts and all
/// dampers take the velocity that is extrapolated from the last two steps.
/// Bilbao, Ducceschi & Zama, J. Comput. Phys. 472, 2023.
class Sav final : public Method {
 public:
  using Method::Method;

  double energy(const NetworkState& state) const noexcept override {
    if (before_.size() == 0) return Method::energy(state);
    double sum = 0.5 * psi_ * psi_ - kShift;
    for (int i = 0; i < model_.masses; ++i)
      sum += 0.5 * motion_.mass()[i] * std::pow((now_[i] - before_[i]) / motion_.k(), 2);
    const auto at = [&](const Vector& x, int slot) {
      return model_.is_mass(slot) ? x[slot] : state.position[index(slot)];
    };
    for (const auto& s : model_.springs)
      sum += 0.5 * s.stiffness * (at(now_, s.upper) - at(now_, s.lower) - s.rest) *
             (at(before_, s.upper) - at(before_, s.lower) - s.rest);
    return model_.with_inductances(sum, state);
  }

 private:
  static constexpr double kShift = 1e-30;  // [J]

  void advance(Vector& x, Vector& v) const override {
    const double k = motion_.k();
    if (fresh_)
      begin(x, v);
    else
      x = now_;  // charges, too
    motion_.linear_force(0.0, x, v, force_);
    motion_.add_losses(x, v, force_);
    force_ += 0.5 * (entered_ + motion_.entering());  // around this instant
    entered_ = motion_.entering();
    double driven = 0.0;
    const double stored = motion_.contact_energy(x, slope_, driven_before_, driven);
    const double root = (psi_ < 0.0 ? -1.0 : 1.0) / std::sqrt(2.0 * stored + 2.0 * kShift);
    slope_ *= root;
    const Vector mobile = (k * k) * slope_.cwiseQuotient(motion_.mass());
    Vector next = 2.0 * x - before_ + (k * k) * force_.cwiseQuotient(motion_.mass());
    const double own = slope_.dot(mobile), past = slope_.dot(before_) - root * driven;
    const double along = (slope_.dot(next) - own * (psi_ - 0.25 * past)) / (1.0 + 0.25 * own);
    next -= mobile * (psi_ + 0.25 * (along - past));
    psi_ += 0.5 * (along - past);
    v = (1.5 * next - 2.0 * x + 0.5 * before_) / k;
    before_ = x;
    driven_before_ = motion_.driven();
    now_ = x = next;
    motion_.count(12.0 * motion_.size() + 8.0);
  }

  /// Inputs count as 0 before the start, which makes the first step exact for any first input.
  void begin(const Vector& x, const Vector& v) const {
    const double k = motion_.k();
    motion_.linear_force(0.0, x, v, force_);
    motion_.add_contacts(0.0, x, v, force_);
    before_ = x - k * v + 0.5 * k * k * force_.cwiseQuotient(motion_.mass());
    entered_ = Vector::Zero(x.size());
    driven_before_ = motion_.driven();
    double none = 0.0;
    psi_ = std::sqrt(2.0 * motion_.contact_energy(x, slope_, driven_before_, none) + 2.0 * kShift);
  }

  mutable Vector force_, slope_, before_, now_, entered_;
  mutable std::vector<double> driven_before_;
  mutable double psi_ = 0;
};

/// A factor of a matrix, dense where it is small.
class Factor {
 public:
  void compute(int size, const Motion::Triplets& entries) {
    size_ = size;
    if (size <= kDense) {
      Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
      for (const auto& e : entries) matrix(e.row(), e.col()) += e.value();
      dense_.compute(matrix);
      return;
    }
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    if (!analysed_) sparse_.analyzePattern(matrix);
    analysed_ = true;
    sparse_.factorize(matrix);
  }
  Vector solve(const Vector& right) const {
    return size_ <= kDense ? Vector(dense_.solve(right)) : Vector(sparse_.solve(right));
  }
  double factor_multiplications() const {
    const double n = size_;
    return size_ <= kDense ? n * n * n / 3.0 : lower() * upper() / n;
  }
  double solve_multiplications() const {
    const double n = size_;
    return size_ <= kDense ? n * n : lower() + upper();
  }

 private:
  static constexpr int kDense = 24;
  double lower() const { return static_cast<double>(sparse_.nnzL()); }
  double upper() const { return static_cast<double>(sparse_.nnzU()); }

  int size_ = 0;
  bool analysed_ = false;
  Eigen::PartialPivLU<Eigen::MatrixXd> dense_;
  mutable Eigen::SparseLU<Eigen::SparseMatrix<double>> sparse_;
};

/// A Runge-Kutta method with two stages for second-order systems: with A_i the accelerations at the stages,
///   M A_i = F(x + k c_i v + k^2 sum (a a)_ij A_j,  v + k sum a_ij A_j)
///   x+ = x + k v + k^2 sum (b a)_j A_j,   v+ = v + k sum b_j A_j
/// by Newton's method; the Jacobian is factored anew where contacts are closed.
class TwoStages final : public Method {
 public:
  struct Tableau {
    Eigen::Matrix2d a;
    Eigen::Vector2d b, c;
    int solved;  ///< stages, the last ones; the others are explicit
  };

  TwoStages(const NetworkModel& model, Tableau tableau)
      : Method(model), tableau_(std::move(tableau)), squared_(tableau_.a * tableau_.a) {
    linear_.compute(unknowns(), slopes());
  }

 private:
  int first() const { return 2 - tableau_.solved; }
  int unknowns() const { return tableau_.solved * motion_.size(); }
  auto stage(Vector& all, int i) const { return all.segment(i * motion_.size(), motion_.size()); }

  /// Of M A - F(A), without contacts.
  Motion::Triplets slopes() const {
    Motion::Triplets entries;
    const int n = motion_.size();
    const double k = motion_.k();
    for (int i = first(); i < 2; ++i) {
      for (int row = 0; row < n; ++row)
        entries.emplace_back((i - first()) * n + row, (i - first()) * n + row, motion_.mass()[row]);
      for (int j = first(); j < 2; ++j)
        motion_.add_linear_slopes(k * k * squared_(i, j), k * tableau_.a(i, j), (i - first()) * n,
                                  (j - first()) * n, entries);
    }
    return entries;
  }

  void advance(Vector& x, Vector& v) const override {
    const double k = motion_.k();
    const int n = motion_.size();
    if (a_.size() == 0 || fresh_) a_ = Vector::Zero(2 * n);
    if (first() == 1) explicit_stage(x, v);
    iterate(x, v);
    const Eigen::RowVector2d way = tableau_.b.transpose() * tableau_.a;
    x += k * v + k * k * (way[0] * stage(a_, 0) + way[1] * stage(a_, 1));
    v += k * (tableau_.b[0] * stage(a_, 0) + tableau_.b[1] * stage(a_, 1));
    motion_.count(5.0 * n);
  }

  void explicit_stage(const Vector& x, const Vector& v) const {
    motion_.linear_force(0.0, x, v, force_);
    force_ += motion_.entering();
    motion_.add_contacts(0.0, x, v, force_);
    stage(a_, 0) = force_.cwiseQuotient(motion_.mass());
    motion_.count(motion_.size());
  }

  void iterate(const Vector& x, const Vector& v) const {
    constexpr int kMostIterations = 30;
    constexpr double kConverged = 1e-13;
    bool was_closed = true;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
      const bool closed = evaluate(x, v);
      if (!closed && !was_closed) return;  // a linear step needs one iteration
      if (closed) factor_closed();
      const auto& factor = closed ? closed_ : linear_;
      const Vector change = factor.solve(residual_);
      motion_.count(factor.solve_multiplications());
      a_.tail(unknowns()) -= change;
      if (model_.contacts.empty() || !(change.norm() > kConverged * a_.tail(unknowns()).norm())) return;
      was_closed = closed;
    }
  }

  /// M A - F(A) of the stages that are solved. True: some contact is closed.
  bool evaluate(const Vector& x, const Vector& v) const {
    const int n = motion_.size();
    const double k = motion_.k();
    residual_.resize(unknowns());
    bool closed = false;
    for (int i = first(); i < 2; ++i) {
      place_[i] =
          x + k * tableau_.c[i] * v + k * k * (squared_(i, 0) * stage(a_, 0) + squared_(i, 1) * stage(a_, 1));
      speed_[i] = v + k * (tableau_.a(i, 0) * stage(a_, 0) + tableau_.a(i, 1) * stage(a_, 1));
      motion_.linear_force(tableau_.c[i], place_[i], speed_[i], force_);
      force_ += motion_.entering();
      closed = motion_.add_contacts(tableau_.c[i], place_[i], speed_[i], force_) || closed;
      residual_.segment((i - first()) * n, n) = motion_.mass().cwiseProduct(stage(a_, i)) - force_;
      motion_.count(6.0 * n);
    }
    return closed;
  }

  void factor_closed() const {
    const int n = motion_.size();
    const double k = motion_.k();
    auto entries = slopes();
    for (int i = first(); i < 2; ++i)
      for (int j = first(); j < 2; ++j)
        motion_.add_contact_slopes(tableau_.c[i], place_[i], speed_[i], k * k * squared_(i, j),
                                   k * tableau_.a(i, j), (i - first()) * n, (j - first()) * n, entries);
    closed_.compute(unknowns(), entries);
    motion_.count(closed_.factor_multiplications());
  }

  Tableau tableau_;
  Eigen::Matrix2d squared_;
  Factor linear_;
  mutable Factor closed_;
  mutable Vector a_, force_, residual_;
  mutable std::array<Vector, 2> place_, speed_;
};

std::unique_ptr<NetworkSolver> make_verlet(const NetworkModel& model) {
  return std::make_unique<Verlet>(model);
}

std::unique_ptr<NetworkSolver> make_newmark(const NetworkModel& model) {
  TwoStages::Tableau trapezoid{{}, {0.5, 0.5}, {0.0, 1.0}, 1};
  trapezoid.a << 0.0, 0.0, 0.5, 0.5;
  return std::make_unique<TwoStages>(model, trapezoid);
}

std::unique_ptr<NetworkSolver> make_sav(const NetworkModel& model) { return std::make_unique<Sav>(model); }

std::unique_ptr<NetworkSolver> make_gauss(const NetworkModel& model) {
  const double r = std::sqrt(3.0) / 6.0;
  TwoStages::Tableau gauss{{}, {0.5, 0.5}, {0.5 - r, 0.5 + r}, 2};
  gauss.a << 0.25, 0.25 - r, 0.25 + r, 0.25;
  return std::make_unique<TwoStages>(model, gauss);
}

}  // namespace

const std::array<PublishedMethod, 4>& published_methods() {
  static constexpr std::array<PublishedMethod, 4> methods{
      {{"verlet", "Störmer–Verlet", "Swope, Andersen, Berens & Wilson, J. Chem. Phys. 76, 1982", make_verlet},
       {"newmark", "Newmark", "Newmark, J. Eng. Mech. 85, 1959", make_newmark},
       {"sav", "SAV", "Bilbao, Ducceschi & Zama, J. Comput. Phys. 472, 2023", make_sav},
       {"gauss", "Gauss–Legendre 2", "Butcher, Math. Comput. 18, 1964", make_gauss}}};
  return methods;
}

const PublishedMethod* find_method(std::string_view name) {
  const auto& all = published_methods();
  const auto found = std::ranges::find(all, name, &PublishedMethod::name);
  return found == all.end() ? nullptr : &*found;
}

std::string why_not_applicable(const NetworkElements& elements) {
  if (!elements.frictions.empty()) return "friction: at rest its force is a set";
  if (!elements.bonds.empty()) return "plectra, magnets or springs in space: their force is not linear";
  if (std::ranges::any_of(elements.springs, [](const Spring& spring) { return spring.axes > 1; }))
    return "springs in space: they act on several axes";
  return {};
}

}  // namespace tactus
