#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/graph/node_type.h"
#include "tests/support/graphs/node_runner.h"

namespace tactus::test {

/// One way to run one node type: everything in it comes from the declaration.
struct NodeCase {
  const NodeType* type = nullptr;
  std::string label;  ///< "filter shape=high seed 3"
  std::map<std::string, std::string> settings;
  std::map<std::string, InputValue> inputs;

  NodeRunner runner() const;
  /// What `NodeRunner` made the node from.
  NodeSetup setup() const;
};

/// Values that a port sees in these tests: a box for its unit, cut to the declared range.
Interval typical_range(const InputPort& port);
/// A constant in it, or the default of the port.
double resting_value(const InputPort& port);
std::map<std::string, Interval> typical_ranges(const NodeType& type);

/// Settings of a type with each choice and each flag in turn, by label. A setting that must be given takes
/// the value of the type's example line, or that of the table in node_cases_test.cpp; without either it is
/// reported by `missing_example`. `motion` is left out: it changes units and no
/// numbers (rotation_test.cpp).
std::map<std::string, std::map<std::string, std::string>> setting_variants(const NodeType& type);
/// The value behind "name = " in a line of a graph file; nullopt if it is not there.
std::optional<std::string> from_example(const std::string& line, const std::string& name);
/// "" or what to do.
std::string missing_example(const NodeType& type);

/// A setting of `setting_variants` as it stands in a graph file; files are named as from their own folder.
std::string as_written(const Setting& setting, const std::string& value);

/// Every variant of the settings with inputs drawn from noise, ramps, trigger trains at odd frames, steps and
/// constants.
std::vector<NodeCase> ordinary_cases(const NodeType& type, int frames, unsigned seeds);
/// Full-scale squares, silence, and 1e30 of either sign at every port that has a bound and must clamp.
std::vector<NodeCase> extreme_cases(const NodeType& type, int frames);

/// An output of the given unit as a plain number, divided by its unit. "=in" follows a plain signal, and
/// "=in/s" is one of it a second.
std::string plain_signal(const std::string& name, std::string unit);

}  // namespace tactus::test
