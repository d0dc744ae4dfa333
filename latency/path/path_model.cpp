#include "latency/path/path_model.h"

#include <Eigen/Dense>
#include <algorithm>
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
constexpr double kDroopEnd = 0.84 * 0.84;
constexpr double kDroopCertain = 4.0;  // standard deviations
constexpr double kFlat = 1e-4;         // log gain: what the ends of windows make

/// The derivatives of ln H: those of delay and odd powers of u are imaginary, the others are real.
constexpr std::array<bool, kFree> kImaginary{true, false, true, false, true, false, false};
std::array<double, kFree> derivatives(double w) {
  const double u = PathModel::kScale / std::max(w, PathModel::kScale);
  const double v = (w / pi) * (w / pi);
  return {-w, 1.0, -u, -u * u, u * u * u, v, v * v};
}

PathModel stepped(PathModel model, const Step& step) {
  model.delay_frames += step[0];
  model.log_gain += step[1];
  for (int k = 2; k < kFree; ++k) model.shape[index(k - 2)] += step[k];
  return model;
}

struct Equations {
  Normal matrix = Normal::Zero();
  Step gradient = Step::Zero();
  double cost = 0.0;      ///< with the belief about the shape
  double error = 0.0;     ///< without
  double power = 0.0;     ///< of what was captured
  double expected = 0.0;  ///< power of the model
  std::size_t bins = 0;

  /// What the bin `b` adds, `free` numbers being free.
  void add(const CapturedWindow& window, std::size_t b, const PathModel& model, int free) {
    const double w = angular_frequency(b, window.size);
    const double weight = 2.0 / window.noise[b];  // a complex bin is two measurements
    const Complex profile = window.profile.empty() ? Complex{1.0} : window.profile[b];
    const Complex answer = model.at(w) * profile * window.played[b];
    const Complex rest = window.captured[b] - answer;
    error += weight * std::norm(rest);
    power += weight * std::norm(window.captured[b]);
    expected += weight * std::norm(answer);
    ++bins;
    const auto slope = derivatives(w);
    const double strength = weight * std::norm(answer);
    const Complex weighted_residual = weight * std::conj(answer) * rest;
    for (std::size_t i = 0; i < index(free); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      gradient[row] += slope[i] * (kImaginary[i] ? weighted_residual.imag() : weighted_residual.real());
      for (std::size_t j = 0; j <= i; ++j)
        if (kImaginary[i] == kImaginary[j])
          matrix(row, static_cast<Eigen::Index>(j)) += strength * slope[i] * slope[j];
    }
  }
};

Equations equations_of(const CapturedWindow& window, const PathModel& model, int free) {
  Equations sum;
  for (auto b = window.lowest_bin; b + 1 < window.captured.size(); ++b) sum.add(window, b, model, free);
  Step belief = Step::Zero();
  std::copy(model.shape.begin(), model.shape.end(), belief.data() + 2);
  sum.cost = sum.error + belief.squaredNorm() / (kShapeDeviation * kShapeDeviation);
  for (int k = 2; k < free; ++k) {
    sum.matrix(k, k) += 1.0 / (kShapeDeviation * kShapeDeviation);
    sum.gradient[k] -= belief[k] / (kShapeDeviation * kShapeDeviation);
  }
  return sum;
}

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
  std::array<double, kFree> numbers{delay_frames, log_gain};
  std::copy(shape.begin(), shape.end(), numbers.begin() + 2);
  double real = 0.0, imaginary = 0.0;
  for (std::size_t k = 0; k < slope.size(); ++k) (kImaginary[k] ? imaginary : real) += numbers[k] * slope[k];
  return sign * std::polar(std::exp(real), imaginary);  // polar() wants no negative magnitude
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
  const int free = shape == PathShape::Free ? kFree : 2;
  PathModel model = start;
  auto equations = equations_of(window, model, free);
  double damping = 1e-3;
  for (int round = 0; round < kPathModelRounds && damping < 1e9; ++round) {
    const auto step = solve(equations, damping, free);
    const auto next = stepped(model, step);
    const auto tried = equations_of(window, next, free);
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
  Normal matrix = equations.matrix.selfadjointView<Eigen::Lower>();
  Step row = Step::Zero();
  const auto solver = matrix.topLeftCorner(free, free).ldlt();
  row.head(free) = solver.solve(Step::Unit(0).head(free));
  std::copy_n(row.data(), fit.delay_row.size(), fit.delay_row.begin());
  fit.delay_deviation = std::sqrt(row[0]);
  fit.gain_deviation = std::sqrt(solver.solve(Step::Unit(1).head(free))[1]);
  if (shape == PathShape::Free)
    fit.high_pass_deviation = std::sqrt(solver.solve(Step::Unit(2).head(free))[2]);
  Step end = Step::Zero();  // where v is that of 0.42 of the sample rate
  end[5] = kDroopEnd;
  end[6] = kDroopEnd * kDroopEnd;
  const double noise = std::sqrt(std::max(0.0, end.head(free).dot(solver.solve(end.head(free)))));
  fit.droop = std::max(
      0.0, std::abs(model.shape[3] * end[5] + model.shape[4] * end[6]) - kDroopCertain * noise - kFlat);
  const auto measurements = 2.0 * static_cast<double>(equations.bins);
  fit.chi_squared = equations.error / measurements;
  fit.strength = std::sqrt(equations.expected / std::max(1.0, fit.chi_squared));
  // The noise's own level is known to a tenth.
  fit.misfit = std::max(0.0, (equations.error - 1.1 * measurements) / equations.power);
  return fit;
}

std::vector<double> delay_influences(const CapturedWindow& window, const Spectrum& captured,
                                     const PathFit& fit, std::span<const std::size_t> edges) {
  std::vector<double> influences;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    double sum = 0.0;
    for (auto b = edges[k]; b < edges[k + 1]; ++b) {
      const double w = angular_frequency(b, window.size);
      const Complex profile = window.profile.empty() ? Complex{1.0} : window.profile[b];
      const Complex answer = fit.model.at(w) * profile * window.played[b];
      const Complex gradient = 2.0 / window.noise[b] * std::conj(answer) * (captured[b] - answer);
      const auto slope = derivatives(w);
      for (std::size_t i = 0; i < slope.size(); ++i)
        sum += fit.delay_row[i] * slope[i] * (kImaginary[i] ? gradient.imag() : gradient.real());
    }
    influences.push_back(sum);
  }
  return influences;
}

}  // namespace tactus
