#pragma once

// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/field.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// The sections of one graph file, without the files that it uses. `file` has no line.
GraphSpec read_graph(const Value::Table& table, const Source& file, ErrorList& errors);

/// format, name, about and source, with which every file begins.
std::vector<FieldType> heading_fields();
/// All keys of a graph; of an entry of [inputs], [controls] and [outputs].
const SectionType& graph_fields();
const SectionType& input_fields();
const SectionType& control_fields();
const SectionType& output_fields();
/// Of a node of a type, beside its ports and settings; of a node that is a part, beside its inputs and
/// controls.
const SectionType& node_fields();
const SectionType& part_fields();

/// `format` of any of our files: must be there and be 1.
void check_format(const Value::Table& table, const Source& file, ErrorList& errors);

/// The table called `section` as named entries that are tables themselves; `example` shows one in the
/// message.
std::vector<EntrySpec> read_entries(const Value::Table& table, const std::string& section,
                                    const std::string& example, ErrorList& errors);

/// The table called `section`; nullptr if it is not there or, with an error, not a table.
const Value::Table* read_section(const Value::Table& table, const std::string& section, ErrorList& errors);

// What the fields of one entry of a graph file mean. Each error is reported once, by the function that finds
// it.

/// The field `unit`: plain if it is left out, nothing after an error.
std::optional<Unit> read_unit(const EntrySpec& entry, ErrorList& errors);

FlatInput read_input(const EntrySpec& entry, ErrorList& errors);

/// A control of the file.
struct ReadControl {
  FlatControl control;
  bool unit_known = true;  ///< false: an error left it open
};
ReadControl read_control(const EntrySpec& entry, ErrorList& errors);

/// `kind` of an output.
OutputUse read_use(const EntrySpec& entry, ErrorList& errors);

/// `[delay]`: the system delays between which the instrument was tested, in seconds; nothing if they are not
/// there or cannot be read.
std::optional<Interval> tested_delays(const GraphSpec& graph, ErrorList& errors);
/// The same without errors, which were reported when the graph was compiled.
std::optional<Interval> tested_delays(const GraphSpec& graph);

}  // namespace tactus
