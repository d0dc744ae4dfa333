#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/study/stability/models/stability_law.h"

namespace tactus {

/// What a signal is of another one, where operations alone lie between: it moves `slope` times as far.
struct Derived {
  const double* source = nullptr;
  double slope = 1;
};

/// By how much signals are moved from where they rest.
using Displaced = std::map<const double*, double>;

/// Which signals are sums and multiples of which, by the buffers that hold them.
class Derivations {
 public:
  /// A signal that nothing is known of is its own source.
  Derived of(const double* signal) const;
  /// By how much a signal moves with its source; nullopt if that is not among `moved`.
  std::optional<double> moved(const double* signal, const Displaced& moved) const;
  /// `in`: the operands' buffers; operands that rest have numbers.
  void note(const double* out, Term::Op op, const double* const in[2], const Operands& operands);

 private:
  std::map<const double*, Derived> known_;
};

/// A law without memory, or the corner of a minimum or maximum, that one signal takes where it answers most.
struct Bend {
  std::string path;
  const double* source = nullptr;
  double to = 0;                         ///< how far the source moves until it is there
  std::function<double(double)> answer;  ///< its slopes' sum where the source has moved so far
};

/// [any] Of a minimum, maximum or absolute value of `from` and what rests; nullopt of other operations.
std::optional<Bend> corner(const std::string& path, Term::Op op, const Operands& operands, int which,
                           const Derived& from);

struct BendPlace {
  std::string name;
  Displaced moved;
};

/// [any] The places at which bending laws are looked at. Laws that answer to one signal are taken where it
/// takes them together: once where each of them answers most, and once where their sum does. Two walls at the
/// ends of a range are never touched at once. Laws on different signals are met in every combination, up to
/// `kMostPlaces`; beyond that there is one place, where nothing is said to have moved and each law is taken
/// where it is steepest by itself.
std::vector<BendPlace> places_of(const std::vector<Bend>& bends);

constexpr std::size_t kMostPlaces = 16;

}  // namespace tactus
