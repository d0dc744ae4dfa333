#pragma once

// Thread: [control].

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/node_type.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {

/// Looks every name up: node types, ports, settings, signals; unfolds parts. `taps` names signals of the top
/// file ("hit", "hit.level") that become outputs of their own.
FlatGraph resolve(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate, ErrorList& errors,
                  const std::vector<std::string>& taps = {}, std::size_t most_signals = 1'000'000);

/// How a part runs at a fraction of the rate around it:
///
///   loop = { use = "loop.toml", rate = "1/16", take = "mean", between = "line", … }
struct PartRate {
  static constexpr int kSlowest = 1024;
  int ratio = 1;      ///< frames around it for one of its own
  bool mean = false;  ///< its inputs are means of the frames since its last one; else what there is
  bool line = false;  ///< its outputs go straight from one sample to the next; else they are held
};

/// [control] `rate`, `take` and `between` of a part; `around` is the rate of the file that uses it.
PartRate read_part_rate(const NodeSpec& node, const GraphSpec& part, Hertz around, ErrorList& errors);

/// [control] The keys of a part beside its inputs and controls, which come first where they have the same
/// name.
std::vector<std::string> part_keys(const GraphSpec& part);

/// What all files of a tree of parts share while their names are looked up.
struct Resolving {
  const NodeTable& table;
  Hertz sample_rate;
  FlatGraph& flat;
  ErrorList& errors;
  std::size_t most_signals;  ///< parts of parts multiply: 32 files that use the next one twice make 2^32
};

/// One file at one place in the tree of parts: first all its names become signals (`declare`), parts
/// included; then its ports are bound (`connect`). Two passes, because loops name what comes
/// later.
class Instance {
 public:
  /// `prefix` ("bridge.") precedes its names in the whole graph; `voices` is how many lanes its user
  /// wants. `outer_divisor` is the rate divisor of the file that uses it.
  Instance(const GraphSpec& spec, Resolving& resolving, std::string prefix, int voices, int outer_divisor = 1,
           PartRate rate = {});

  void declare_top();
  void connect_top(const std::vector<std::string>& taps);

 private:
  struct PendingNode {
    const EntrySpec* spec;
    std::size_t flat;
  };
  struct PendingPart {
    const NodeSpec* spec;
    std::unique_ptr<Instance> instance;
    int first_output;  ///< its signal; those of the other outputs follow
  };

  Hertz sample_rate() const { return Hertz{resolving_.sample_rate.value / divisor_}; }
  FlatSignal& signal(int id) { return flat_.signals[index(id)]; }
  int add_signal(const std::string& name, const Source& at, FlatSignal::Kind kind, int index, int port = 0);
  int add_expression(const std::string& name, const Source& at);

  // Names (declare.cpp).
  void declare_input(const EntrySpec& entry);
  void declare_control(const EntrySpec& entry);
  void declare_system();
  void declare_inside();
  void declare_node(const NodeSpec& node);
  void declare_network(const NetworkSpec& network);
  void declare_outputs(const EntrySpec& entry, std::shared_ptr<const NodeType> type, bool bare_name);
  void declare_part(const NodeSpec& node);
  bool too_large(const NodeSpec& node);
  void declare_part_outputs(const NodeSpec& node, const GraphSpec& part, const Instance& instance);
  void declare_as_part();
  int declare_binding(const EntrySpec& entry);

  // Ports (connect.cpp).
  void connect_inside();
  void connect_node(const EntrySpec& entry, FlatNode& node);
  void connect_ports(const EntrySpec& entry, FlatNode& node, const std::string& owner);
  void connect_compensation(const EntrySpec& entry, const std::string& field, FlatNode& node);
  void connect_part(const PendingPart& pending);
  void check_part_fields(const NodeSpec& node, const Instance& part);
  void bind_output(const EntrySpec& entry, Expression& expression, std::optional<Dimension>& declared);
  void connect_output(const EntrySpec& entry);
  void connect_tap(const std::string& name);

  const GraphSpec& spec_;
  Resolving& resolving_;
  FlatGraph& flat_;
  ErrorList& errors_;
  std::string prefix_;
  int voices_;
  int outer_divisor_, divisor_;  ///< engine frames between two of its user's, and of its own
  PartRate rate_;
  Scope scope_;
  std::map<std::string, int> nodes_by_name_;
  std::map<std::string, int> bindings_;  ///< a part's inputs and controls: their signals
  std::vector<std::unique_ptr<EntrySpec>> network_entries_;
  std::vector<PendingNode> pending_nodes_;
  std::vector<PendingPart> pending_parts_;
};

}  // namespace tactus
