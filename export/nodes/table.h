#pragma once

// Thread: [control].

#include <span>
#include <string_view>

#include "engine/dsp/filters/filter_kernel.h"
#include "export/nodes/node_writer.h"

namespace tactus {

/// How a type of node is exported: what its kernel needs, as C text.
struct NodeExport {
  const char* type;
  void (*write)(NodeWriter& node);
  const char* kernel = "";  ///< for a `write` that several types have in common: see there
  const char* state = "";   ///< the type of its state
  /// Of filters: the text for `filter_design`, for whose phase delay others may be compensated.
  std::string (*design)(const NodeExport& entry, const NodeSetup& setup) = nullptr;
  /// The same coefficients as numbers, for a cutoff in radians per frame, a q and a sample rate.
  tactus_filter_design (*coefficients)(const NodeSetup& setup, double radians, double q,
                                       double rate) = nullptr;
  int passes = -1;     ///< the input that, while not finite, makes the first output so in the same frame
  bool picks = false;  ///< what it gives is one of its inputs
};

/// [any] The families, each in the file of its name.
std::span<const NodeExport> exported_delays();
std::span<const NodeExport> exported_envelopes();
std::span<const NodeExport> exported_filters();
std::span<const NodeExport> exported_generators();
std::span<const NodeExport> exported_logic();
std::span<const NodeExport> exported_mechanics();
std::span<const NodeExport> exported_networks();
std::span<const NodeExport> exported_shapers();

/// [any] The entry of a type of node, or nullptr.
const NodeExport* find_node_export(std::string_view type);

/// The C text of a filter's coefficients: that of the entry with $1 and $2, the parameters of the node, and
/// $rate.
std::string filter_design(const std::string& kernel, const std::vector<std::string>& parameters,
                          const std::string& rate);

/// A call of the kernel with the inputs in order, and perhaps one more argument.
inline std::string kernel_call(const NodeWriter& node, const std::string& first,
                               const std::string& further = {}) {
  std::string arguments = first;
  for (int i = 0; i < static_cast<int>(node.setup().inputs.size()); ++i)
    arguments += (arguments.empty() ? "" : ", ") + node.in(i);
  return node.kernel() + "(" + arguments + (further.empty() ? "" : ", " + further) + ")";
}

/// A node of one output whose kernel is a function of its state and its inputs, of these and the rate, or of
/// the inputs alone.
template <class State>
void write_step(NodeWriter& node) {
  node.give(0, kernel_call(node, "&" + node.state<State>(node.state_type())));
}
template <class State>
void write_step_at_rate(NodeWriter& node) {
  node.give(0, kernel_call(node, "&" + node.state<State>(node.state_type()), node.rate()));
}
inline void write_value(NodeWriter& node) { node.give(0, kernel_call(node, "")); }

}  // namespace tactus
