#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "engine/physics/network.h"

namespace tactus::test {

/// A network of masses, linear springs and frictions, each friction between one mass and a driven or fixed
/// point, no two of which hold the same mass at once. Inputs are those of frame n.
struct StickSlip {
  std::string name;
  NetworkElements elements;
  int signals = 0, frames = 0, look_at = 0;
  std::function<void(int frame, double* inputs)> inputs;
};

/// Its motion by Runge-Kutta steps of a small part of a frame, each stick and each slip located by bisection:
/// a frame starts at each call. Shares nothing with the solvers but the coefficient of friction.
class StickSlipMotion {
 public:
  StickSlipMotion(const StickSlip& scene, Hertz rate, int parts)
      : scene_(scene), k_(1 / rate.value), parts_(parts), slides_(scene.elements.frictions.size()) {
    for (const auto& p : scene.elements.points) y_.x.push_back(p.position), y_.v.push_back(p.velocity);
    now_.resize(index(scene.signals));
    scene.inputs(0, now_.data());
    for (std::size_t p = 0; p < y_.x.size(); ++p)
      if (driven(p)) y_.x[p] = now_[index(point(p).input.signal)];
  }

  double position(int of) const { return y_.x[index(of)]; }

  /// From frame n to n + 1.
  void frame(int n) {
    scene_.inputs(n, now_.data());
    for (std::size_t p = 0; p < y_.x.size(); ++p)
      if (driven(p)) y_.v[p] = (now_[index(point(p).input.signal)] - y_.x[p]) / k_;
    for (std::size_t f = 0; f < slides_.size(); ++f)
      if (slides_[f] == 0 && std::abs(slip(y_, f)) > 1e-12) slides_[f] = slip(y_, f) > 0 ? 1 : -1;
    for (int part = 0; part < parts_; ++part) advance(k_ / parts_);
  }

 private:
  struct Numbers {
    std::vector<double> x, v;
  };
  const Point& point(std::size_t p) const { return scene_.elements.points[p]; }
  bool driven(std::size_t p) const { return point(p).kind == Point::Kind::Motion; }
  const Friction& friction(std::size_t f) const { return scene_.elements.frictions[f]; }
  double slip(const Numbers& y, std::size_t f) const {
    return y.v[index(friction(f).lower)] - y.v[index(friction(f).upper)];
  }
  std::size_t rubbed(std::size_t f) const {
    const auto lower = index(friction(f).lower);
    return point(lower).kind == Point::Kind::Mass ? lower : index(friction(f).upper);
  }
  double normal(std::size_t f) const {
    const int signal = friction(f).normal.signal;
    return signal < 0 ? 0.0 : now_[index(signal)];
  }
  double holding(std::size_t f) const { return normal(f) * friction(f).law.holding(); }

  /// On each point; of frictions those that slide.
  std::vector<double> forces(const Numbers& y) const {
    std::vector<double> force(y.x.size());
    for (const auto& s : scene_.elements.springs) {
      const auto lower = index(s.lower), upper = index(s.upper);
      const double pull =
          s.stiffness * (y.x[upper] - y.x[lower] - s.rest) + s.damping * (y.v[upper] - y.v[lower]);
      force[lower] += pull, force[upper] -= pull;
    }
    for (std::size_t f = 0; f < slides_.size(); ++f) {
      if (slides_[f] == 0) continue;
      const double speed = std::max(0.0, slides_[f] * slip(y, f));
      const double push = slides_[f] * normal(f) * friction(f).law.coefficient(speed);
      force[index(friction(f).lower)] -= push, force[index(friction(f).upper)] += push;
    }
    return force;
  }

  /// What a friction that holds has to push with, against `lower`.
  double held(const Numbers& y, std::size_t f) const {
    const auto at = rubbed(f);
    return forces(y)[at] * (at == index(friction(f).lower) ? 1.0 : -1.0);
  }

  Numbers rates(const Numbers& y) const {
    Numbers slope{y.v, forces(y)};
    for (std::size_t p = 0; p < y.x.size(); ++p)
      slope.v[p] = point(p).kind == Point::Kind::Mass ? slope.v[p] / point(p).mass : 0.0;
    for (std::size_t f = 0; f < slides_.size(); ++f)
      if (slides_[f] == 0) slope.v[rubbed(f)] = 0.0;
    return slope;
  }

  static Numbers sum(const Numbers& y, double h, const Numbers& slope) {
    Numbers to = y;
    for (std::size_t i = 0; i < to.x.size(); ++i) to.x[i] += h * slope.x[i], to.v[i] += h * slope.v[i];
    return to;
  }
  Numbers stepped(double h) const {
    const auto a = rates(y_), b = rates(sum(y_, h / 2, a)), c = rates(sum(y_, h / 2, b)),
               d = rates(sum(y_, h, c));
    return sum(sum(sum(sum(y_, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
  }

  /// Below 0: something began to slide or to hold.
  double margin(const Numbers& y, std::size_t f) const {
    return slides_[f] == 0 ? holding(f) - std::abs(held(y, f)) : slides_[f] * slip(y, f);
  }

  void advance(double seconds) {
    for (int events = 0; seconds > 0.0; ++events) {
      auto to = stepped(seconds);
      double done = seconds;
      for (std::size_t f = 0; events < 8 && f < slides_.size(); ++f) {
        if (margin(to, f) >= 0.0) continue;
        double low = 0.0, high = done;
        for (int i = 0; i < 60 && high - low > 1e-9 * k_; ++i) {
          const double middle = 0.5 * (low + high);
          (margin(stepped(middle), f) < 0.0 ? high : low) = middle;
        }
        to = stepped(done = high);
      }
      y_ = to;
      seconds -= done;
      if (seconds > 0.0 || done > 0.0) switch_over();
    }
  }

  void switch_over() {
    for (std::size_t f = 0; f < slides_.size(); ++f) {
      if (margin(y_, f) >= 0.0) continue;
      const auto at = rubbed(f);
      y_.v[at] += (at == index(friction(f).lower) ? -1.0 : 1.0) * slip(y_, f);
      slides_[f] = 0;
      if (margin(y_, f) < 0.0) slides_[f] = held(y_, f) > 0.0 ? 1 : -1;
    }
  }

  const StickSlip& scene_;
  double k_;
  int parts_;
  std::vector<int> slides_;
  Numbers y_;
  std::vector<double> now_;
};

/// Largest error of a position, relative to its largest value, at the frames.
inline double stick_slip_error(const StickSlip& scene, const std::vector<double>& truth, Hertz rate,
                               Solver solver, int oversample) {
  const auto network = Network::make(scene.elements, scene.signals, rate, solver, oversample).value();
  auto state = network.initial_state();
  std::vector<double> inputs(index(scene.signals));
  double most = 0.0, largest = 0.0;
  for (int n = 0; n < scene.frames; ++n) {
    scene.inputs(n, inputs.data());
    network.step(state, inputs.data());
    most = std::max(most, std::abs(network.position(state, scene.look_at) - truth[index(n)]));
    largest = std::max(largest, std::abs(truth[index(n)]));
  }
  return most / largest;
}

inline std::vector<double> stick_slip_truth(const StickSlip& scene, Hertz rate, int parts) {
  StickSlipMotion motion(scene, rate, parts);
  std::vector<double> truth;
  for (int n = 0; n < scene.frames; ++n) {
    motion.frame(n);
    truth.push_back(motion.position(scene.look_at));
  }
  return truth;
}

}  // namespace tactus::test
