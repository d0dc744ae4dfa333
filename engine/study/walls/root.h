#pragma once

namespace tactus {

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
