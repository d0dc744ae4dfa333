#pragma once

// Thread: [control].

#include <optional>
#include <string>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/graph/file/value.h"
#include "engine/graph/node_type.h"
#include "engine/graph/semantics/expression.h"
#include "engine/graph/semantics/interval.h"

namespace tactus {

/// What is known about the unit of a signal: nothing yet (a loop), a bare number that fits anywhere, or a
/// unit.
struct UnitFact {
  enum class Kind { Unknown, Bare, Known } kind = Kind::Unknown;
  Dimension dimension;

  static UnitFact known(Dimension d) { return {Kind::Known, d}; }
  static UnitFact bare() { return {Kind::Bare, {}}; }
  bool operator==(const UnitFact& o) const {
    return kind == o.kind && (kind != Kind::Known || dimension == o.dimension);
  }
};

/// How a signal comes into a part with a rate of its own, or out of it: see RateConverter.
struct RateConversion {
  enum class How { Last, Smooth, Trigger };
  int from = 1;  ///< engine frames between two samples of what it is made of
  How how = How::Last;
};

struct FlatSignal {
  /// Missing replaces what an error of the file left out, so that it raises no second error.
  enum class Kind { Missing, Input, Control, SystemDelay, SystemRate, Expression, NodeOutput };

  Kind kind = Kind::Expression;
  std::string path = {};  ///< "bridge.loss.low"
  Source at = {};
  int index = -1;                                 ///< of the control or node
  int port = 0;                                   ///< of the node's output
  Expression expression = {};                     ///< Expression
  std::optional<Dimension> declared = {};         ///< the unit that the file gives
  int divisor = 1;                                ///< engine frames between two samples
  std::optional<RateConversion> conversion = {};  ///< Expression at the border of a part
  // Inferred:
  UnitFact unit = {};
  int lanes = 1;
  Interval range = {};
};

struct FlatNode {
  std::string path;
  Source at;
  std::shared_ptr<const NodeType> type;
  std::vector<std::optional<Expression>> inputs = {};  ///< declaration order; nullopt: left out
  std::vector<SettingValue> settings = {};             ///< declaration order
  std::vector<int> outputs = {};                       ///< signals, declaration order
  std::vector<int> compensate = {};                    ///< nodes whose phase delay is taken off `time`
  int voices = 1;                                      ///< lanes asked for with `voices`
  int divisor = 1;                                     ///< engine frames between two of its own
  int lanes = 1;                                       ///< inferred
  std::vector<Interval> ranges = {};                   ///< inferred, of the inputs

  /// As messages call it, by its name in its own file: "delay 'echo'".
  std::string label() const { return type->name + " '" + path.substr(path.rfind('.') + 1) + "'"; }
};

/// What of a MIDI keyboard's notes a control follows.
enum class MidiRole { None, Note, Velocity, NoteOn, NoteOff };

struct FlatControl {
  std::string name;
  double value = 0;  ///< SI
  Unit unit = {};    ///< how people read it; in decibels it also ramps
  Interval range = {};
  double smooth_s = 0.010;
  MidiRole midi = MidiRole::None;
  std::string about = {};  ///< for people
};

enum class OutputUse { Drive, Audio, Tap };

struct FlatOutput {
  std::string name;
  OutputUse use = OutputUse::Drive;
  Expression expression = {};
  Source at = {};
  std::optional<Dimension> declared = {};
  Dimension dimension = {};  ///< inferred
  int lanes = 1;
};

/// A graph with all its parts unfolded and every name looked up; still with lanes.
struct FlatGraph {
  static constexpr int kMissing = 0;  ///< signal 0 is of kind Missing
  std::vector<FlatSignal> signals;
  std::vector<FlatNode> nodes;
  std::vector<FlatControl> controls;
  std::vector<FlatOutput> outputs;
  bool too_large = false;  ///< parts were left out, with an error: there are more than `most_signals`
};

enum class Roots { FirstToLast, LastToFirst };

/// [any] The strongly connected components of a directed graph, each behind all that it reaches. `next[v]`:
/// the vertices that v leads to; `roots`: in which order the search begins at vertices not seen yet. Not
/// recursive: a graph may be a chain of 100,000 vertices. Source: Tarjan, SIAM J. Comput. 1(2), 1972.
std::vector<std::vector<int>> strong_components(const std::vector<std::vector<int>>& next, Roots roots);

}  // namespace tactus
