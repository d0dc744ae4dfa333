#pragma once

// Thread: [control]. A declaration is made once and constant from then on: reading it is [any].

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/field.h"
#include "engine/graph/node.h"
#include "engine/graph/semantics/interval.h"

namespace tactus {

/// A port that takes a signal: an expression, a name, a quantity or a number.
struct InputPort {
  std::string name;
  /// "ms", "N/m", "" (plain), "any" (not checked), or "=in" (the unit of the port `in`, whatever that is).
  /// Bare numbers count in the SI unit of the dimension.
  std::string unit;
  std::string doc;
  std::optional<double> fallback = {};  ///< when the file does not name the port; nullopt: it must
  double low = -kUnlimited;  ///< valid range, SI; constants and controls outside it are an error in the
  double high = kUnlimited;  ///< file, signals outside it are clamped by the node
  bool late = false;         ///< may close a loop: read by `absorb` (see Node)
  bool fixed = false;        ///< must be constant: it is needed when the node is made
  bool hold = false;         ///< least time between two events of the node (event-driven nodes)
  bool samples = false;      ///< a trigger: the output is the first input at the last one
};

enum class OutputKind { Signal, Trigger };

struct OutputPort {
  std::string name;
  /// As InputPort::unit; also "=in/s" and the like: the unit of a port times a unit.
  std::string unit;
  std::string doc;
  OutputKind kind = OutputKind::Signal;
  bool event_level = false;  ///< how strong the last event of the node was
  Interval range = {};       ///< guaranteed
};

/// A field that is read once, when the file is loaded: a word, a table, a file's name.
using Setting = FieldType;

/// The setting, of nodes and networks, that says whether their units are those of translation, in which they
/// are declared, or of rotation (see `in_rotation`).
inline constexpr const char* kMotionSetting = "motion";
inline constexpr const char* kTranslation = "translation";
inline constexpr const char* kRotation = "rotation";

/// What the compiler knows about an input when it makes the node.
struct InputInfo {
  Interval range;                  ///< guaranteed by interval arithmetic; unbounded if nothing is known
  std::optional<double> constant;  ///< the value, if it never changes
  bool connected = false;          ///< named in the file
  mutable bool asked = false;      ///< the node that was made depends on it
};

struct NodeType;

/// Memory limit of all nodes of a graph: a line of a file can ask for more than a machine has.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::size_t bytes) : bytes_(bytes), left_(bytes) {}
  /// [control] Errors: OutOfRange where the limit is exceeded.
  Status take(std::size_t numbers);

 private:
  std::size_t bytes_, left_;
};

/// All that a node is made from.
struct NodeSetup {
  Hertz sample_rate;
  const NodeType* type = nullptr;
  std::vector<InputInfo> inputs;       ///< declaration order
  std::vector<SettingValue> settings;  ///< declaration order
  int lane = 0;
  int lanes = 1;                   ///< of all of the node
  MemoryBudget* memory = nullptr;  ///< nullptr: as much as there is
  std::vector<bool> read = {};     ///< outputs that something reads; empty: all
  /// Set by `NodeType::make`: what else distinguishes the node that was made (what it has left out).
  mutable std::uint64_t variant = 0;

  /// [control] Must be called before a node allocates more numbers than its settings hold.
  Status take_memory(std::size_t numbers) const;
  /// Marks the input as `asked`: the node depends on the result. Fixed ports may be read directly.
  const InputInfo& input(std::string_view name) const;
  const SettingValue& setting(std::string_view name) const;
};

/// Where the phase delays of other nodes are added to a time of a node.
struct PhaseCompensation {
  int port, period;  ///< inputs, both [s]: the time that is changed; the period at which phase is taken
  double sign;       ///< +1: the phase delays are added to the time; -1: they are subtracted
};

/// An input that keeps outputs at 0 for as long as it has always been 0.
struct Silencer {
  std::string input;
  std::string output = {};  ///< empty: all
};

using MakeNode = std::function<Result<std::unique_ptr<Node>>(const NodeSetup&)>;

/// The declaration of a kind of node: validation, `tactus nodes` and docs/nodes.md are all made from it.
struct NodeType {
  std::string name;
  std::string group = {};  ///< heading in the reference, set by the table: "filters", "delays", …
  std::string summary;     ///< one sentence
  std::string equation;    ///< plain text, symbols as the ports are named
  std::string source;      ///< where the method comes from
  std::string example;     ///< one line of a graph file
  std::vector<InputPort> inputs;
  std::vector<OutputPort> outputs;  ///< the first is what the node's bare name means
  std::vector<Silencer> silencers = {};
  std::vector<Setting> settings = {};
  MakeNode make;
  /// No memory: with constant inputs it is evaluated once, when the graph is compiled.
  bool stateless = false;
  /// Written twice it is meant to be two (noise).
  bool random = false;
  /// All lanes of the input are summed into one lane of output: the compiler makes additions of the node.
  bool reduces_lanes = false;
  /// Near its pitch its phase turns by a full circle, so that it has no phase delay to compensate.
  bool resonant = false;
  /// The node compensates the phase delays of the nodes that its `Names` setting lists.
  std::optional<PhaseCompensation> compensation = {};
  /// Of an input without `Node::response`: the gain from the first input that the node comes close to while
  /// its signal moves far enough. nullopt: such an input is event-driven and has no small-signal gain.
  std::optional<double> small_signal_gain = {};
  /// Its output stays where it is while its first input moves little, or until a trigger.
  bool dead_band = false;
  /// Its first output passes the triggers of its first input on, each once.
  bool passes_triggers = false;
  /// Unread outputs may be given as nullptr (networks: hundreds of outputs, few of them read).
  bool skips_unused_outputs = false;
  /// Which inputs matter to the outputs that are read (`NodeSetup::read`); empty: all. Nothing is computed
  /// for the others. Of an input that may change, nothing is known but its range.
  std::function<std::vector<bool>(const NodeSetup&)> needed_inputs = {};
  /// What it declares in units of translation turns: rad for m, N m for N (networks; see `kMotionSetting`).
  bool turns = false;
  /// Distinguishes declarations of one name (networks).
  std::uint64_t fingerprint = 0;
  /// Range of an output, given the ranges of the inputs; empty: OutputPort::range.
  std::function<Interval(int output, const NodeSetup&)> range = {};

  /// Index in `inputs`, or -1.
  int input_index(std::string_view port) const;
};

struct NetworkSpec;

/// Every kind of node that a graph file can name. Filled by engine/nodes (`standard_nodes()`).
struct NodeTable {
  std::vector<const NodeType*> types;

  /// Turns one `[networks.x]` into the declaration of one node: its inputs are the fields of the elements
  /// that take signals ("coil.voltage"), its outputs what the elements can be asked for ("stick.position").
  /// Structural errors (unknown element types and keys, elements that do not exist) come back all at once.
  std::function<Checked<std::shared_ptr<const NodeType>>(const NetworkSpec&)> network;

  /// What to write in place of a name that other programs have for a node ("lfo"); "" if it is none.
  std::function<std::string(std::string_view)> other_name = {};

  /// nullptr if there is no such type.
  const NodeType* find(std::string_view name) const {
    const auto found =
        std::find_if(types.begin(), types.end(), [&](auto* type) { return type->name == name; });
    return found == types.end() ? nullptr : *found;
  }
};

}  // namespace tactus
