#pragma once

// Thread: [any]
#include <cmath>

namespace tactus {

/// Two places between which a function changes its sign, and its values there.
struct Bracket {
  double near, far;  ///< |f(near)| <= |f(far)|
  double f_near, f_far;
};

/// Narrows a bracket to `width`, or until it meets a 0, by inverse quadratic interpolation where that is safe
/// and by halving where it is not: never slower than halving by more than a few steps. f(low) and f(high)
/// have unlike signs, or one of them is 0. Chandrupatla, Adv. Eng. Software 28(3), 1997.
template <class Function>
Bracket find_zero(const Function& f, double low, double high, double width) {
  double a = high, fa = f(high), b = low, fb = f(low), c = b, fc = fb, share = 0.5;
  while (true) {
    const bool a_near = std::abs(fa) <= std::abs(fb);
    const double least = width / std::abs(b - a);
    if (least >= 1.0 || fa == 0.0 || fb == 0.0) return a_near ? Bracket{a, b, fa, fb} : Bracket{b, a, fb, fa};
    const double x = a + share * (b - a), fx = f(x);
    if ((fx < 0.0) == (fa < 0.0)) {
      c = a, fc = fa;
    } else {
      c = b, fc = fb;
      b = a, fb = fa;
    }
    a = x, fa = fx;
    if (a + 0.5 * (b - a) == a || a + 0.5 * (b - a) == b) return {a, b, fa, fb};  // no number lies between
    const double xi = (a - b) / (c - b), phi = (fa - fb) / (fc - fb);
    share = 0.5;
    if (phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi)
      share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb);
    const double edge = std::fmin(0.5, width / std::abs(b - a));
    share = std::fmax(edge, std::fmin(1.0 - edge, share));
  }
}

/// Where `f` changes its sign between `low` and `high`, both of one sign or 0: by bisection, to `part` of the
/// root; 0: to the last bit that halving can reach. At `low` the sign is that just above it: f(low) itself
/// may be 0.
template <class Function>
double root_between(double low, double high, const Function& f, double part = 0) {
  const bool positive_at_end = f(high) > 0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high || high - low <= part * high) break;
    ((f(middle) > 0) == positive_at_end ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tactus
