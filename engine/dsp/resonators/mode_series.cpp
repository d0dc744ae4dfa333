#include "engine/dsp/resonators/mode_series.h"

#include <algorithm>
#include <cmath>

#include "engine/core/find_root.h"
#include "engine/core/units.h"

namespace tactus {
namespace {

/// Where cos b = sign / cosh b, for k = 1, 2, …: next to the zeros of the cosine, whence Newton's method
/// needs a few steps.
double bar_root(int k, double sign) {
  double b = (sign > 0 ? k + 0.5 : k - 0.5) * kPi;
  for (int i = 0; i < 10; ++i) {
    const double ends = sign / std::cosh(b);
    b -= (std::cos(b) - ends) / (-std::sin(b) + ends * std::tanh(b));
  }
  return b;
}

/// The Bessel function J_order(x); libc++ lacks that of C++17, and the C library of its systems has its own.
double bessel_j(int order, double x) {
#ifdef __STDCPP_MATH_SPEC_FUNCS__
  return std::cyl_bessel_j(order, x);
#else
  return ::jn(order, x);
#endif
}

/// The zeros of all J_m in (0, end), rising. J_m has none up to m, and two are more than 3 apart.
std::vector<double> membrane_roots(double end) {
  std::vector<double> roots;
  for (int order = 0; order < end; ++order) {
    const auto bessel = [order](double x) { return bessel_j(order, x); };
    double before = std::max(0.5, 1.0 * order), value = bessel(before);
    for (double at = before + 1; at < end; ++at) {
      const double next = bessel(at);
      if ((next < 0) != (value < 0)) roots.push_back(root_between(before, at, bessel));
      before = at, value = next;
    }
  }
  std::sort(roots.begin(), roots.end());
  return roots;
}

std::vector<double> membrane(int modes) {
  // Below x lie about x^2 / 8 zeros; the search ends on the whole numbers.
  std::vector<double> roots;
  for (double end = 8 + std::sqrt(8.0 * modes); static_cast<int>(roots.size()) < modes; end *= 1.25)
    roots = membrane_roots(std::ceil(end));
  roots.resize(static_cast<std::size_t>(modes));
  return roots;
}

/// `at(k)` for k = 1 … modes.
template <class At>
std::vector<double> listed(int modes, At at) {
  std::vector<double> values;
  for (int k = 1; k <= modes; ++k) values.push_back(at(k));
  return values;
}

std::vector<double> unscaled(ModeSeries series, int modes, double span) {
  const auto square = [](double b) { return b * b; };
  switch (series) {
    case ModeSeries::Geometric:
      return listed(modes, [=](int k) { return std::pow(span, (k - 1.0) / std::max(1, modes - 1)); });
    case ModeSeries::Bar:
      return listed(modes, [=](int k) { return square(bar_root(k, 1)); });
    case ModeSeries::ClampedBar:
      return listed(modes, [=](int k) { return square(bar_root(k, -1)); });
    case ModeSeries::Membrane:
      return membrane(modes);
    case ModeSeries::Harmonic:
      break;
  }
  return listed(modes, [](int k) { return double(k); });
}

}  // namespace

std::vector<double> mode_ratios(ModeSeries series, int modes, double span) {
  auto ratios = unscaled(series, modes, span);
  const double first = ratios.front();
  for (auto& ratio : ratios) ratio /= first;
  return ratios;
}

}  // namespace tactus
