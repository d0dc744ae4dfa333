#pragma once

// Thread: [any].

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace tactus::study {

/// What a filter does:  y = b0 x + b1 x1 + b2 x2 + a1 y1 + a2 y2.
struct Taps {
  double b0 = 0, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
};
Taps one_pole(double cutoff, double rate);
Taps matched_one_pole(double cutoff, double rate);
Taps dc_blocker(double cutoff, double rate);
Taps velocity(double cutoff, double rate);
Taps difference(double rate);
Taps low_pass(double cutoff, double q, double rate);
Taps high_pass(double cutoff, double q, double rate);
Taps band_pass(double frequency, double q, double rate);

/// Masses, springs and dampers:  M x'' + C x' + K x = f.
struct Masses {
  Eigen::VectorXd m;
  Eigen::MatrixXd k, c;
  explicit Masses(int count)
      : m(Eigen::VectorXd::Ones(count)),
        k(Eigen::MatrixXd::Zero(count, count)),
        c(Eigen::MatrixXd::Zero(count, count)) {}
  /// Between two masses; `other` -1: and the ground.
  void join(int one, int other, double stiffness, double damping);
};
enum class Method { Explicit, Passive, Implicit, Exact };

/// What `respond` does to the input: 1 for a while, once parts with rates of their own have begun.
constexpr bool pushed(long frame) { return frame >= 40 && frame < 140; }

/// A linear system, stepped frame by frame as docs/graph_files.md, docs/networks.md and the equations of the
/// nodes say. Shares nothing with the engine. Blocks run in the order in which they are added, after delays
/// and masses, which give what they have from the frames before.
class Circuit {
 public:
  using Signal = int;

  /// What comes from outside: 0 but in `respond`.
  Signal input();
  Signal sum(const std::vector<std::pair<double, Signal>>& terms);
  Signal filter(Signal in, const Taps& taps);
  /// Lagrange's polynomial through order + 1 frames; order 0: the nearest frame. At least a frame.
  Signal delay(double frames, int order);
  void feed(Signal delay, Signal in);
  /// Positions and velocities of masses, alternating.
  std::vector<Signal> masses(const Masses& masses, Method method, double rate);
  void push(Signal first_position, int mass, Signal force, double newtons = 1);

  /// From now on blocks run in every `divisor`th frame alone, until `end_part`.
  void begin_part(int divisor);
  void end_part();
  Signal mean(Signal in, int divisor);
  Signal line(Signal in, int divisor);
  /// The input of every `period`th frame, the first of which is `first`.
  Signal hold(Signal in, int period, int first);

  int states() const { return static_cast<int>(states_); }
  /// ln of the largest eigenvalue, per frame.
  double growth() const;
  /// The output when the input is `pushed`.
  std::vector<double> respond(int frames, Signal output) const;

 private:
  struct Frame {
    double* signal;
    double* state;
    long number;
  };
  using Run = std::function<void(const Frame&)>;
  Signal add_signal() { return static_cast<int>(signals_++); }
  std::size_t add_states(int count) {
    states_ += static_cast<std::size_t>(count);
    return states_ - static_cast<std::size_t>(count);
  }
  void add(std::vector<Run>& to, Run run);
  void step(std::vector<double>& signals, std::vector<double>& state, long number) const;

  std::size_t signals_ = 0, states_ = 0;
  std::vector<Run> early_, run_, late_;
  std::vector<Signal> inputs_;
  struct Moving {
    Signal first;
    std::size_t state;
    int count;
    Eigen::MatrixXd step, force;
    std::vector<std::pair<std::pair<int, Signal>, double>> pushes = {};
  };
  std::vector<std::shared_ptr<Moving>> moving_;
  struct Line {
    Signal out;
    std::size_t state;
    int length, divisor;
  };
  std::vector<Line> delays_;
  int divisor_ = 1, period_ = 1;
};

}  // namespace tactus::study
