#pragma once

// Thread: [any].

#include <algorithm>
#include <array>
#include <compare>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {

struct Plan;

/// The operating point of an operation.
struct Operands {
  OperandValues at{};
  std::array<bool, kMostOperands> moves{};

  int moving() const { return static_cast<int>(std::count(moves.begin(), moves.end(), true)); }
};

/// d(out)/d(operand `which`) of an operation. At a corner (a minimum, a maximum, an absolute value)
/// `touched` takes the side where the moving operand comes through. nullopt: it steps there, or its slope is
/// not finite.
std::optional<double> slope_of(const Operator& type, const Operands& operands, int which, bool touched);

/// Whether output `output` is a force that depends on a position at `input`.
bool is_spring(const NodeType& type, std::size_t input, std::size_t output);

/// The steepest point of a nonlinearity without memory.
struct SteepPlace {
  std::vector<double> at;  ///< its inputs there
  double answer = 0;       ///< sum of the slopes; of a force that depends on a position only restoring ones
  bool nonlinear = false;  ///< its slope differs elsewhere
  int input = -1;          ///< the one displaced; the first that can be, if none was
};

/// The sum of its slopes at `at`.
double answer_at(const Node& node, const NodeType& type, const std::vector<double>& at,
                 const std::vector<bool>& moves);

struct Summit {
  double at = 0, height = 0;
};

/// The highest point of a curve found from `start` and around each of the middles: from 1e-6 to 1e3 to both
/// sides, and uphill from the best of these.
Summit summit(const std::function<double(double)>& height, double start, const std::vector<double>& middles);

/// Searches around the operating point, around 0, and around each constant input (where a clip, a wall or a
/// detent begins), one moving input at a time.
SteepPlace steepest(const Node& node, const NodeType& type, const std::vector<double>& at,
                    const std::vector<bool>& moves);

/// An output of a vertex of one of the plans that are analysed together.
struct PlanSignal {
  const Plan* plan = nullptr;  ///< identifies the plan, no more
  int vertex = -1, port = 0;
  auto operator<=>(const PlanSignal&) const = default;
};

/// An affine function of another signal: it moves `slope` times as far.
struct Derived {
  PlanSignal source;
  double slope = 1;
};

/// Displacements of signals from their resting values.
using Displaced = std::map<PlanSignal, double>;

/// Signals as affine functions of others.
class AffineMaps {
 public:
  /// An unknown signal is its own source.
  Derived of(const PlanSignal& signal) const;
  /// By how much a signal moves with its source; nullopt if that is not among `moved`.
  std::optional<double> moved(const PlanSignal& signal, const Displaced& moved) const;
  /// `in`: the operands; constant ones are not read.
  void note(const PlanSignal& out, const Operator& type, const std::array<PlanSignal, kMostOperands>& in,
            const Operands& operands);

 private:
  std::map<PlanSignal, Derived> known_;
};

/// A nonlinearity without memory, or the corner of a minimum or maximum, with its steepest point.
struct Nonlinearity {
  std::string path;
  PlanSignal source;
  double to = 0;                             ///< displacement of the source at the steepest point
  std::function<double(double)> answer;      ///< sum of its slopes at a displacement of the source
  std::function<double(double)> slope = {};  ///< the same with its sign
  /// Displacements at which its slope is another one: of straight lines all, else the lowest and highest.
  std::vector<double> elsewhere = {};
  int signal = -1;  ///< of the graph: what it gives
};

/// Where a slope is another than at 0 and at `but`, found from 1e-6 to 1e3 to both sides of each of the
/// middles.
std::vector<double> places_of_slopes(const std::function<double(double)>& slope, double but,
                                     const std::vector<double>& middles);

/// The key of the choice between two operands of a minimum, a maximum or `select` that move with different
/// signals: it is displaced by the number of the operand that passes.
PlanSignal choice_at(PlanSignal out);

/// Of a minimum, maximum or absolute value of `from` and a constant; nullopt of other operations.
std::optional<Nonlinearity> corner(const std::string& path, const Operator& type, const Operands& operands,
                                   int which, const Derived& from);
/// Of a minimum or maximum of two that move, `out`.
Nonlinearity corner_of_two(const std::string& path, const PlanSignal& out, const Operator& type,
                           const Operands& operands, const std::array<Derived, 2>& from);
/// Of a curve with a limited slope.
Nonlinearity curve(const std::string& path, const Operator& type, const Operands& operands,
                   const Derived& from);
/// Of a choice between the second and the third operand, `out`.
Nonlinearity choice(const std::string& path, const PlanSignal& out, const Operands& operands);

struct OperatingPoint {
  std::string name;
  Displaced moved;
  bool certain = true;  ///< false: see `operating_points`
};

/// The operating points at which nonlinearities are linearised. Those of one signal are displaced together:
/// once to the steepest point of each, once to that of their sum, and to where their slopes are others. Two
/// walls at the ends of a range are never touched at once. Nonlinearities of different signals are combined
/// in every way, up to `kMostPlaces`; beyond that those of each signal are displaced alone, and a last point
/// without displacements, where each is linearised at its own steepest point, is not certain ever to be met.
std::vector<OperatingPoint> operating_points(const std::vector<Nonlinearity>& laws);

constexpr std::size_t kMostPlaces = 16;

}  // namespace tactus
