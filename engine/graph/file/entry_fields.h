#pragma once

// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

// What the fields of one entry of a graph file say. Each mistake is reported once, by the function that finds
// it.

/// A mistake for each field that is not in `known`; `owner` ("clip 'a'") says whose they are.
void check_fields(const EntrySpec& entry, const std::vector<std::string>& known, const std::string& owner,
                  Mistakes& mistakes);

/// A whole number from `low` to `high`; `low` after a mistake.
int read_whole_number(const Value& value, const std::string& what, int low, int high, Mistakes& mistakes);

/// The field `unit`: plain if it is left out, nothing after a mistake.
std::optional<Unit> read_unit(const EntrySpec& entry, Mistakes& mistakes);

FlatInput read_input(const EntrySpec& entry, Mistakes& mistakes);

/// A control of the file.
struct ReadControl {
  FlatControl control;
  bool unit_known = true;  ///< false: a mistake left it open
};
ReadControl read_control(const EntrySpec& entry, Mistakes& mistakes);

/// What `kind` of an output says.
OutputUse read_use(const EntrySpec& entry, Mistakes& mistakes);

/// `[delay]`: the system delays between which the instrument was tried.
void check_tested_delays(const EntrySpec& entry, Mistakes& mistakes);
/// What it says, in seconds; nothing if it says nothing that can be read.
std::optional<Interval> tested_delays(const GraphSpec& graph);

/// A control's value as its unit shows it: "-34 dB", "0.012 m".
std::string in_unit(double si, const Unit& unit);

}  // namespace tactus
