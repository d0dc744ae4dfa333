#include "latency/path/path_model.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "engine/core/index.h"

namespace tactus {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr int kFree = 7;  // delay, log gain, three of the high pass, two of the droop
using Normal = Eigen::Matrix<double, kFree, kFree>;
using Step = Eigen::Matrix<double, kFree, 1>;

constexpr int kPathModelRounds = 30;
constexpr double kPathModelSettled = 1e-6;  // frames; each step squares what is left
// What coupling capacitors and filters of sound cards do stays well within one: without such a belief, noise
// alone could bend the shape as it likes at frequencies where nothing is detected.
constexpr double kShapeDeviation = 1.0;

/// The derivatives of ln H: those of delay and odd powers of u are imaginary, the others are real.
constexpr std::array<bool, kFree> kImaginary{true, false, true, false, true, false, false};
std::array<double, kFree> derivatives(double w) {
  const double u = PathModel::kScale / std::max(w, PathModel::kScale);
  const double v = (w / pi) * (w / pi);
  return {-w, 1.0, -u, -u * u, u * u * u, v, v * v};
}

PathModel moved(PathModel model, const Step& step) {
  model.delay_frames += step[0];
  model.log_gain += step[1];
  for (int k = 0; k < 3; ++k) model.high_pass[index(k)] += step[2 + k];
  for (int k = 0; k < 2; ++k) model.droop[index(k)] += step[5 + k];
  return model;
}

Step shape_of(const PathModel& model) {
  Step shape;
  shape << 0.0, 0.0, model.high_pass[0], model.high_pass[1], model.high_pass[2], model.droop[0],
      model.droop[1];
  return shape;
}

struct Equations {
  Normal matrix = Normal::Zero();
  Step gradient = Step::Zero();
  double cost = 0.0;      ///< with the belief about the shape
  double error = 0.0;     ///< without
  double power = 0.0;     ///< of what was captured
  double expected = 0.0;  ///< power of the model
  std::size_t bins = 0;
};

/// What one bin adds.
class Bins {
 public:
  Bins(const CapturedWindow& window, PathShape shape)
      : window_(window), free_(shape == PathShape::Free ? kFree : 2) {}

  int free() const { return free_; }

  Equations equations(const PathModel& model) const {
    Equations sum;
    for (auto b = window_.lowest_bin; b + 1 < window_.captured.size(); ++b) add(b, model, sum);
    const auto belief = shape_of(model);
    sum.cost = sum.error + belief.squaredNorm() / (kShapeDeviation * kShapeDeviation);
    for (int k = 2; k < free_; ++k) {
      sum.matrix(k, k) += 1.0 / (kShapeDeviation * kShapeDeviation);
      sum.gradient[k] -= belief[k] / (kShapeDeviation * kShapeDeviation);
    }
    return sum;
  }

 private:
  void add(std::size_t b, const PathModel& model, Equations& sum) const {
    const double w = angular_frequency(b, window_.size);
    const double weight = 2.0 / window_.noise[b];  // a complex bin is two measurements
    const Complex profile = window_.profile.empty() ? Complex{1.0} : window_.profile[b];
    const Complex expected = model.at(w) * profile * window_.played[b];
    const Complex rest = window_.captured[b] - expected;
    sum.error += weight * std::norm(rest);
    sum.power += weight * std::norm(window_.captured[b]);
    sum.expected += weight * std::norm(expected);
    ++sum.bins;
    const auto slope = derivatives(w);
    const double strength = weight * std::norm(expected);
    const Complex pull = weight * std::conj(expected) * rest;
    for (std::size_t i = 0; i < index(free_); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      sum.gradient[row] += slope[i] * (kImaginary[i] ? pull.imag() : pull.real());
      for (std::size_t j = 0; j <= i; ++j)
        if (kImaginary[i] == kImaginary[j])
          sum.matrix(row, static_cast<Eigen::Index>(j)) += strength * slope[i] * slope[j];
    }
  }

  const CapturedWindow& window_;
  int free_;
};

Step solve(const Equations& equations, double damping, int free) {
  Normal matrix = equations.matrix.selfadjointView<Eigen::Lower>();
  matrix.diagonal() *= 1.0 + damping;
  Step step = Step::Zero();
  step.head(free) = matrix.topLeftCorner(free, free).ldlt().solve(equations.gradient.head(free));
  return step;
}

}  // namespace

Complex PathModel::at(double w) const {
  const auto slope = derivatives(w);
  const std::array numbers{delay_frames, log_gain, high_pass[0], high_pass[1],
                           high_pass[2], droop[0], droop[1]};
  double real = 0.0, imaginary = 0.0;
  for (std::size_t k = 0; k < slope.size(); ++k) (kImaginary[k] ? imaginary : real) += numbers[k] * slope[k];
  return std::polar(sign * std::exp(real), imaginary);
}

Spectrum PathModel::spectrum(std::size_t size, const Spectrum& profile) const {
  Spectrum all(size / 2 + 1);
  for (std::size_t b = 1; b < all.size(); ++b) {
    all[b] = at(angular_frequency(b, size));
    if (!profile.empty()) all[b] *= profile[b];
  }
  return all;
}

PathFit fit_path(const CapturedWindow& window, const PathModel& start, PathShape shape) {
  const Bins bins{window, shape};
  PathModel model = start;
  auto equations = bins.equations(model);
  double damping = 1e-3;
  for (int round = 0; round < kPathModelRounds && damping < 1e9; ++round) {
    const auto step = solve(equations, damping, bins.free());
    const auto next = moved(model, step);
    const auto tried = bins.equations(next);
    if (!(tried.cost <= equations.cost)) {
      damping = damping * 30.0 + 1e-9;
      continue;
    }
    model = next;
    equations = tried;
    damping *= 0.1;
    if (std::abs(step[0]) < kPathModelSettled) break;
  }
  PathFit fit;
  fit.model = model;
  const auto free = bins.free();
  Normal matrix = equations.matrix.selfadjointView<Eigen::Lower>();
  fit.delay_deviation = std::sqrt(matrix.topLeftCorner(free, free).ldlt().solve(Step::Unit(0).head(free))[0]);
  const auto measurements = 2.0 * static_cast<double>(equations.bins);
  fit.chi_squared = equations.error / measurements;
  fit.strength = std::sqrt(equations.expected / std::max(1.0, fit.chi_squared));
  // The noise's own level is known to a tenth.
  fit.misfit = std::max(0.0, (equations.error - 1.1 * measurements) / equations.power);
  return fit;
}

}  // namespace tactus
