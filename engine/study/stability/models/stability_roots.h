#pragma once

// Thread: [control].

#include <complex>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "engine/core/units.h"
#include "engine/study/stability/stability_loops.h"

namespace tactus {

/// A root of the closed loops: e^((growth + j 2 pi frequency) t).
struct LoopRoot {
  double frequency_hz = 0;
  double growth_per_s = 0;  ///< below 0 it decays
};
/// The fastest growing first; at most `most`.
void sort_by_growth(std::vector<LoopRoot>& roots, std::size_t most);

/// How far one cut is from where a root crosses the unit circle. Factors on what goes through it.
struct CutMargin {
  double up = std::numeric_limits<double>::infinity();  ///< the least factor above 1 at which one crosses
  double up_hz = 0;
  double down = 0;  ///< the largest factor below 1 at which one crosses
  /// The loop is stable for all factors up to this one (of an unstable loop: the largest stable one, or 0).
  double border = std::numeric_limits<double>::infinity();
  double border_hz = 0;
  double peak = 0;  ///< largest |L|: below 1 the loop is stable at every delay and phase
  double peak_hz = 0;
  /// Additional delay until a root crosses; infinite if |L| stays below 1, 0 if a root grows already.
  double more_delay_s = std::numeric_limits<double>::infinity();
};

/// Growth per second on the circle that is scanned: slower growth counts as none.
inline constexpr double kSlowestGrowth = 1e-4;

/// Evaluates f(z) = det(1 - R(z)) of a loop group along the circle |z| = 1 + tiny, on which a root doubles in
/// two hours, with points so close that f never turns by more than a fraction from one to the
/// next.
class LoopScan {
 public:
  enum class For {
    Margins,
    Counting,  ///< `growing` alone: fewer points, and less at each of them
  };
  LoopScan(const LoopGroup& group, Hertz rate, For what = For::Margins);

  /// False: there are more turns than points, so that none of what follows is certain.
  bool complete() const { return complete_; }
  /// Roots outside the circle, from the turns of f around 0 (Cauchy's argument principle; f has no poles
  /// there if no network grows by itself).
  int growing() const;
  /// The same with everything that goes through a cut times `factor`.
  int growing_with(int cut, double factor) const;
  CutMargin margin(int cut) const;
  /// The least damped roots, from the valleys of |f| by Newton's method; at most `most`.
  std::vector<LoopRoot> roots(std::size_t most) const;
  /// The root of f nearest to a frequency, with everything through a cut times `factor`.
  std::optional<LoopRoot> root_near(double hertz, int cut, double factor) const;

 private:
  struct Sample {
    double radians = 0;
    std::complex<double> f;
    std::vector<std::complex<double>> alone;  ///< L of each cut
  };
  struct Crossing {
    double factor, radians;
  };
  Sample sample(double radians) const;
  std::vector<double> first_points() const;
  void add_ringing(const LinearEdge& edge, int base, std::vector<double>& points) const;
  std::vector<std::complex<double>> first_guesses(std::size_t most) const;
  void refine(std::vector<double> points);
  bool smooth(const Sample& a, const Sample& b) const;
  std::vector<Crossing> crossings(int cut) const;
  std::optional<Crossing> crossing_between(double a, double b, int cut) const;
  void find_border(int cut, const std::vector<Crossing>& crossings, CutMargin& margin) const;
  double delay_margin(int cut) const;
  std::optional<LoopRoot> newton(std::complex<double> s, int cut, double factor) const;
  double hertz(double radians) const;

  template <class Value>
  int turns(const Value& value) const;

  const LoopGroup& group_;
  Hertz rate_;
  For what_;
  double radius_;
  bool complete_ = true;
  std::vector<std::complex<double>> poles_;  ///< of the networks in the loop
  std::vector<Sample> samples_;              ///< from 0 to half the rate
  std::vector<double> heights_;  ///< of each cut's L among the first points, at most 1: what counts as near 0
};

/// What keeps a force law on a sampled and held device passive.
struct PassiveLimit {
  double device_damping = 0;  ///< b: Re{1 / (jw G)} near 0 Hz, minus half a step of the hold [N s/m]
  double factor = 0;          ///< the largest on what goes through a cut for which b is enough; 0: none
};
/// The passivity of a force law on a sampled and held device (Colgate & Schenkel, J. Robotic Systems
/// 14(1), 1997): it adds no more energy than the device dissipates, whoever holds it, while
///     b > (T/2) / (1 - cos wT) Re{(1 - e^-jwT) H(e^jwT)}    for 0 < w <= pi/T,
/// with H the force on the device against its position, delays included. Here H = -L / G: L what comes back
/// to the cut at the drive, G from a force on the device to its position. `drive`: the one cut that the force
/// goes through.
PassiveLimit passive_limit(const LoopGroup& group, int drive, int cut,
                           const std::function<std::complex<double>(std::complex<double>)>& mobility,
                           Hertz rate);

}  // namespace tactus
