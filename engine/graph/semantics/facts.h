#pragma once

// Thread: [control].

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {

/// The range that a part declares for an input or a control, and the signal that it is given.
struct PartRange {
  int signal;
  Interval range;
  Unit unit;
  std::string owner;   ///< "'strength' of part 'spring'"
  bool whole = false;  ///< takes whole numbers only

  /// Whether no value of `found` is inside. Of a signal that may be on both sides, nothing is known.
  bool excludes(Interval found) const {
    return (found.bounded() && (found.high < range.low || found.low > range.high)) || is_fraction(found);
  }
  /// A constant fraction where a whole number is wanted.
  bool is_fraction(Interval found) const {
    return whole && found.single() && std::floor(found.low) != found.low;
  }
};

struct Resolved {
  FlatGraph graph;
  std::vector<PartRange> part_ranges;
};

/// Looks every name up: node types, ports, settings, signals; unfolds parts. `taps` names signals of the top
/// file ("hit", "hit.level") that become outputs of their own.
Resolved resolve(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate, ErrorList& errors,
                 const std::vector<std::string>& taps, std::size_t most_signals);

// What is known of an expression once the facts about its signals are: asked again and again while they are
// inferred.

/// Lanes of an expression; 0 if any number of them fits (a spread).
int lanes_of(const FlatGraph& graph, const Expression& expression);

/// Unit of an expression. Only known units can contradict each other.
UnitFact unit_of(const FlatGraph& graph, const Expression& expression);
UnitFact product(UnitFact a, UnitFact b, bool divide);

/// Whether operand `i` has the unit that others have, and that the whole has.
bool shares_unit(const Expression& expression, std::size_t i);

/// Of an expression without signals.
std::optional<double> constant_of(const Expression& expression);

/// All values that an expression can take.
Interval range_of(const FlatGraph& graph, const Expression& expression);
/// Those of the operands of an operator.
OperandRanges operand_ranges(const FlatGraph& graph, const Expression& expression);
/// Of an input of a node, its fallback included.
Interval input_range(const FlatGraph& graph, const FlatNode& node, std::size_t input);

/// What a lane of a node is made from, except for its inputs; `sample_rate` is the engine's.
NodeSetup setup_of(const FlatNode& node, Hertz sample_rate, int lane = 0);

/// The unit of a port: fixed, unchecked, or that of another port times something ("=in/s").
struct PortUnit {
  enum class Kind { Any, Fixed, Follows } kind = Kind::Fixed;
  Dimension dimension;
  int follows = -1;  ///< input port
};
/// Whether it moves in rotation: a network says so itself, a node by `kMotionSetting`.
bool turns(const FlatNode& node);
PortUnit port_unit(const FlatNode& node, const std::string& declared);

/// Works out and checks the unit, the number of lanes and the range of every signal, loops included, and
/// fills them in. Each fact starts as "unknown" and passes are made until nothing changes; ranges start
/// unbounded and only shrink, so they are valid at every pass. What a part is given outside its range is
/// reported once: inside the part it counts as within.
void infer(FlatGraph& graph, const std::vector<PartRange>& part_ranges, ErrorList& errors);

/// Where units, lanes and ranges, once inferred, contradict each other or what a port wants; by place. A
/// error in the file of a part that is used twice is reported once.
void check_facts(const FlatGraph& graph, const std::vector<PartRange>& part_ranges, ErrorList& errors);

}  // namespace tactus
