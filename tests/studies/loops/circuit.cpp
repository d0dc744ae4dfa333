#include "tests/studies/loops/circuit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/MatrixFunctions>

namespace tactus::study {
namespace {

constexpr double kPi = std::numbers::pi;

double radians(double hertz, double rate) { return 2 * kPi * std::min(hertz / rate, 0.49); }

/// 1 - p, with p^2 - 2 (2 - cos w) p + 1 = 0.
double matched_gain(double w) {
  const double c = 2 - std::cos(w);
  return 1 - (c - std::sqrt(c * c - 1));
}

/// Of the bilinear transform s = (1 - z^-1) / (1 + z^-1) / tan(w / 2).
Taps bilinear(double n0, double n1, double n2, double w, double q) {
  const double t = std::tan(w / 2), d0 = 1 + t / q + t * t;
  return {(n0 * t * t + n1 * t + n2) / d0, (2 * n0 * t * t - 2 * n2) / d0, (n0 * t * t - n1 * t + n2) / d0,
          -(2 * t * t - 2) / d0, -(1 - t / q + t * t) / d0};
}

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

Taps one_pole(double cutoff, double rate) {
  const double t = std::tan(radians(cutoff, rate) / 2), p = (1 - t) / (1 + t);
  return {(1 - p) / 2, (1 - p) / 2, 0, p, 0};
}
Taps matched_one_pole(double cutoff, double rate) {
  const double gain = matched_gain(radians(cutoff, rate));
  return {gain, 0, 0, 1 - gain, 0};
}
Taps dc_blocker(double cutoff, double rate) {
  const double p = 1 / (1 + radians(cutoff, rate));
  return {p, -p, 0, p, 0};
}
Taps velocity(double cutoff, double rate) {
  const double gain = matched_gain(radians(cutoff, rate));
  return {gain * rate, -gain * rate, 0, 1 - gain, 0};
}
Taps difference(double rate) { return {rate, -rate, 0, 0, 0}; }
Taps low_pass(double cutoff, double q, double rate) { return bilinear(1, 0, 0, radians(cutoff, rate), q); }
Taps high_pass(double cutoff, double q, double rate) { return bilinear(0, 0, 1, radians(cutoff, rate), q); }
Taps band_pass(double frequency, double q, double rate) {
  return bilinear(0, 1 / q, 0, radians(frequency, rate), q);
}

void Masses::join(int one, int other, double stiffness, double damping) {
  const auto put = [&](Eigen::MatrixXd& into, double value) {
    into(one, one) += value;
    if (other < 0) return;
    into(other, other) += value;
    into(one, other) -= value;
    into(other, one) -= value;
  };
  put(k, stiffness);
  put(c, damping);
}

void Circuit::add(std::vector<Run>& to, Run run) {
  if (divisor_ == 1) return to.push_back(std::move(run));
  to.push_back([run = std::move(run), divisor = divisor_](const Frame& f) {
    if (f.number % divisor == 0) run(f);
  });
}

Circuit::Signal Circuit::input() {
  inputs_.push_back(add_signal());
  return inputs_.back();
}

Circuit::Signal Circuit::sum(const std::vector<std::pair<double, Signal>>& terms) {
  const auto out = add_signal();
  add(run_, [terms, out](const Frame& f) {
    double total = 0;
    for (const auto& [factor, signal] : terms) total += factor * f.signal[signal];
    f.signal[out] = total;
  });
  return out;
}

Circuit::Signal Circuit::filter(Signal in, const Taps& t) {
  const auto out = add_signal();
  const auto s = add_states(4);
  add(run_, [=](const Frame& f) {
    double* x = f.state + s;
    const double now = f.signal[in];
    const double y = t.b0 * now + t.b1 * x[0] + t.b2 * x[1] + t.a1 * x[2] + t.a2 * x[3];
    x[1] = x[0], x[0] = now, x[3] = x[2], x[2] = y;
    f.signal[out] = y;
  });
  return out;
}

Circuit::Signal Circuit::delay(double frames, int order) {
  const int newest =
      std::max(1, order == 0 ? static_cast<int>(frames + 0.5) : static_cast<int>(frames) - (order - 1) / 2);
  std::vector<double> weights(at(order + 1), 1.0);
  for (int k = 0; k <= order; ++k)
    for (int j = 0; j <= order; ++j)
      if (j != k) weights[at(k)] *= (frames - newest - j) / (k - j);
  const auto out = add_signal();
  const int length = newest + order;
  const auto s = add_states(length);
  add(early_, [=](const Frame& f) {
    double total = 0;
    for (int k = 0; k <= order; ++k) total += weights[at(k)] * f.state[s + at(newest - 1 + k)];
    f.signal[out] = total;
  });
  delays_.push_back({out, s, length, divisor_});
  return out;
}

void Circuit::feed(Signal delay, Signal in) {
  const auto line = *std::ranges::find(delays_, delay, &Line::out);
  late_.push_back([=](const Frame& f) {
    if (f.number % line.divisor != 0) return;
    double* x = f.state + line.state;
    std::copy_backward(x, x + line.length - 1, x + line.length);
    x[0] = f.signal[in];
  });
}

/// The state is x, q = the way of the last step, and q of the step before; `Exact`: x and v.
std::vector<Circuit::Signal> Circuit::masses(const Masses& of, Method method, double rate) {
  const auto n = of.m.size();
  const double t = 1 / rate;
  auto moving = std::make_shared<Moving>();
  moving->count = static_cast<int>(n);
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(n, n), none = Eigen::MatrixXd::Zero(n, n);
  const Eigen::MatrixXd m = of.m.asDiagonal();
  Eigen::MatrixXd read(2 * n, method == Method::Exact ? 2 * n : 3 * n);
  if (method == Method::Exact) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    a.block(0, n, n, n) = one;
    a.block(n, 0, n, n) = -m.inverse() * of.k;
    a.block(n, n, n, n) = -m.inverse() * of.c;
    a.block(n, 2 * n, n, n) = m.inverse();
    const Eigen::MatrixXd e = Eigen::MatrixXd(a * t).exp();
    moving->step = e.topLeftCorner(2 * n, 2 * n);
    moving->force = e.topRightCorner(2 * n, n);
    read = Eigen::MatrixXd::Identity(2 * n, 2 * n);
  } else {
    Eigen::MatrixXd solve = m / (t * t);
    if (method != Method::Explicit) solve += of.c / (2 * t);
    if (method == Method::Implicit) solve += of.k / 4;
    const Eigen::MatrixXd inverse = solve.inverse();
    const Eigen::MatrixXd by_x = -inverse * of.k, by_q = -inverse * of.c / t;
    moving->step.resize(3 * n, 3 * n);
    moving->step << one + by_x, one + by_q, none, by_x, one + by_q, none, none, one, none;
    moving->force.resize(3 * n, n);
    moving->force << inverse, inverse, none;
    read << one, none, none, none, 1.5 * one / t, -0.5 * one / t;
  }
  const auto size = static_cast<int>(moving->step.rows()), count = static_cast<int>(n);
  moving->state = add_states(size + count);  // and the forces of the frame before
  std::vector<Signal> signals;
  for (Eigen::Index i = 0; i < 2 * n; ++i) signals.push_back(add_signal());
  moving->first = signals.front();
  early_.push_back([=](const Frame& f) {
    const Eigen::Map<const Eigen::VectorXd> x(f.state + moving->state, size);
    const Eigen::VectorXd y = read * x;
    for (Eigen::Index i = 0; i < n; ++i) {
      f.signal[moving->first + 2 * i] = y[i];
      f.signal[moving->first + 2 * i + 1] = y[n + i];
    }
  });
  late_.push_back([=](const Frame& f) {
    Eigen::Map<Eigen::VectorXd> x(f.state + moving->state, size);
    Eigen::Map<Eigen::VectorXd> before(f.state + moving->state + size, count);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(count);
    for (const auto& [where, newtons] : moving->pushes)
      force[where.first] += newtons * f.signal[where.second];
    // A force that is held from frame to frame: its mean around the frame.
    const Eigen::VectorXd acts = method == Method::Exact ? force : Eigen::VectorXd(0.5 * (force + before));
    x = Eigen::VectorXd(moving->step * x + moving->force * acts);
    before = force;
  });
  moving_.push_back(std::move(moving));
  return signals;
}

void Circuit::push(Signal first_position, int mass, Signal force, double newtons) {
  for (const auto& moving : moving_)
    if (moving->first == first_position) moving->pushes.push_back({{mass, force}, newtons});
}

void Circuit::begin_part(int divisor) {
  divisor_ = divisor;
  period_ = std::lcm(period_, divisor);
}
void Circuit::end_part() { divisor_ = 1; }

Circuit::Signal Circuit::mean(Signal in, int divisor) {
  const auto out = add_signal();
  const auto s = add_states(divisor - 1);
  run_.push_back([=](const Frame& f) {
    double total = f.signal[in];
    for (int i = 0; i < divisor - 1; ++i) total += f.state[s + at(i)];
    f.signal[out] = total / divisor;
    double* x = f.state + s;
    std::copy_backward(x, x + divisor - 2, x + divisor - 1);
    x[0] = f.signal[in];
  });
  return out;
}

Circuit::Signal Circuit::line(Signal in, int divisor) {
  const auto out = add_signal();
  const auto s = add_states(2);  // y[m - 1], y[m]
  run_.push_back([=](const Frame& f) {
    const auto j = f.number % divisor;
    if (j == 0) f.state[s] = f.state[s + 1], f.state[s + 1] = f.signal[in];
    const double share = static_cast<double>(j) / divisor;
    f.signal[out] = (1 - share) * f.state[s] + share * f.state[s + 1];
  });
  return out;
}

Circuit::Signal Circuit::hold(Signal in, int period, int first) {
  const auto out = add_signal();
  const auto s = add_states(1);
  period_ = std::lcm(period_, period);
  run_.push_back([=](const Frame& f) {
    if (f.number % period == first) f.state[s] = f.signal[in];
    f.signal[out] = f.state[s];
  });
  return out;
}

void Circuit::step(std::vector<double>& signals, std::vector<double>& state, long number) const {
  const Frame frame{signals.data(), state.data(), number};
  for (const auto* list : {&early_, &run_, &late_})
    for (const auto& run : *list) run(frame);
}

double Circuit::growth() const {
  Eigen::MatrixXd a(states(), states());
  for (int i = 0; i < states(); ++i) {
    std::vector<double> state(states_), signals(signals_);
    state[at(i)] = 1;
    for (int n = 0; n < period_; ++n) step(signals, state, n);
    a.col(i) = Eigen::Map<const Eigen::VectorXd>(state.data(), states());
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> solved(a, false);
  return std::log(solved.eigenvalues().cwiseAbs().maxCoeff()) / period_;
}

std::vector<double> Circuit::respond(int frames, Signal output) const {
  std::vector<double> state(states_), signals(signals_), responded;
  for (int n = 0; n < frames; ++n) {
    if (!inputs_.empty()) signals[at(inputs_.front())] = pushed(n) ? 1.0 : 0.0;
    step(signals, state, n);
    responded.push_back(signals[at(output)]);
  }
  return responded;
}

}  // namespace tactus::study
