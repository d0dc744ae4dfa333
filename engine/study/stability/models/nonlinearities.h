#pragma once

// Thread: [any].

#include <array>
#include <compare>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/study/stability/models/stability_law.h"

namespace tactus {

struct Plan;

/// An output of a vertex of one of the plans that are analysed together.
struct PlanSignal {
  const Plan* plan = nullptr;  ///< identifies the plan, no more
  int vertex = -1, port = 0;
  auto operator<=>(const PlanSignal&) const = default;
};

/// What a signal is of another one, where operations alone lie between: it moves `slope` times as far.
struct Derived {
  PlanSignal source;
  double slope = 1;
};

/// By how much signals are moved from where they rest.
using Displaced = std::map<PlanSignal, double>;

/// Which signals are sums and multiples of which.
class AffineMaps {
 public:
  /// A signal that nothing is known of is its own source.
  Derived of(const PlanSignal& signal) const;
  /// By how much a signal moves with its source; nullopt if that is not among `moved`.
  std::optional<double> moved(const PlanSignal& signal, const Displaced& moved) const;
  /// `in`: the operands; those that rest are not read.
  void note(const PlanSignal& out, Expression::Op op, const std::array<PlanSignal, 2>& in,
            const Operands& operands);

 private:
  std::map<PlanSignal, Derived> known_;
};

/// A law without memory, or the corner of a minimum or maximum, that one signal takes where it answers most.
struct Nonlinearity {
  std::string path;
  PlanSignal source;
  double to = 0;                         ///< how far the source moves until it is there
  std::function<double(double)> answer;  ///< its slopes' sum where the source has moved so far
};

/// [any] Of a minimum, maximum or absolute value of `from` and what rests; nullopt of other operations.
std::optional<Nonlinearity> corner(const std::string& path, Expression::Op op, const Operands& operands,
                                   int which, const Derived& from);

struct OperatingPoint {
  std::string name;
  Displaced moved;
};

/// [any] The places at which bending laws are looked at. Laws that answer to one signal are taken where it
/// takes them together: once where each of them answers most, and once where their sum does. Two walls at the
/// ends of a range are never touched at once. Laws on different signals are met in every combination, up to
/// `kMostPlaces`; beyond that there is one place, where nothing is said to have moved and each law is taken
/// where it is steepest by itself.
std::vector<OperatingPoint> operating_points(const std::vector<Nonlinearity>& bends);

constexpr std::size_t kMostPlaces = 16;

}  // namespace tactus
