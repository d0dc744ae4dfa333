#pragma once

// Thread: [control].

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/graph/node_type.h"
#include "export/fixed/arithmetic.h"
#include "export/fixed/operators.h"

namespace tactus {

/// Helps to write a node in integers: `in` and `give` are in the order of its declaration.
class FixedNode {
 public:
  /// What the code around it offers.
  struct Around {
    std::function<std::string(const std::string& type, const std::string& suffix, int count)> state;
    std::function<FixedValue(const FixedValue& value, const std::string& suffix)> local;
    std::function<void(std::string)> start, step, late;
    MakeTable table;
    /// A constant at file scope; returns its name.
    std::function<std::string(const std::string& type, const std::string& suffix, const std::string& value)>
        declare;
    /// The number of an input that only controls decide, which are then fixed.
    std::function<std::optional<double>(int input)> freeze;
    std::function<void(std::string reason, std::string remedy)> refuse;
    /// The range and the error of what a state takes over from pass to pass: grows until it stays.
    std::function<FixedValue(Interval range, double error)> kept;
  };

  FixedNode(const NodeSetup& setup, FixedArithmetic& arithmetic, std::vector<FixedValue> inputs,
            std::vector<bool> read, bool wide, Around offered)
      : around(std::move(offered)),
        setup_(setup),
        arithmetic_(arithmetic),
        inputs_(std::move(inputs)),
        read_(std::move(read)),
        wide_(wide) {
    values.resize(read_.size(), FixedArithmetic::number(0));
  }

  const NodeSetup& setup() const { return setup_; }
  double rate() const { return setup_.sample_rate.value; }
  const std::string& setting(std::string_view name) const { return setup_.setting(name).text; }
  FixedArithmetic& arithmetic() { return arithmetic_; }
  const FixedValue& in(int input) const { return inputs_[index(input)]; }
  FixedValue word(int input) const { return arithmetic_.word(in(input)); }
  bool reads(int output) const { return read_[index(output)]; }
  /// What reads the first output only limits it.
  bool wide() const { return wide_; }
  /// The number of an input that never changes; refuses the node if it may, and gives 1.
  double constant(int input);
  void give(int output, const FixedValue& value) { values[index(output)] = value; }

  Around around;
  std::vector<FixedValue> values;
  bool refused = false;

 private:
  const NodeSetup& setup_;
  FixedArithmetic& arithmetic_;
  std::vector<FixedValue> inputs_;
  std::vector<bool> read_;
  bool wide_;
};

struct FixedNodeType {
  const char* type;
  void (*write)(FixedNode& node);
  bool limits = false;  ///< takes wide inputs: it limits them
};

/// [any] The entry of a type of node, or nullptr.
const FixedNodeType* find_fixed_node(std::string_view type);
std::vector<std::string> fixed_node_names();

}  // namespace tactus
