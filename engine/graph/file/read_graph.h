#pragma once

// Thread: [control]

#include <string>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/field.h"
#include "engine/graph/file/spec.h"

namespace tactus {

/// The sections of one graph file, without the files that it uses. `file` has no line.
GraphSpec read_graph(const Value::Table& table, const Source& file, ErrorList& errors);

/// format, name, about and source, with which every file begins.
std::vector<FieldType> heading_fields();
/// All keys of a graph.
const SectionType& graph_fields();
/// Of a node of a type, beside its ports and settings; of a node that is a part, beside its inputs and
/// controls.
const SectionType& node_fields();
const SectionType& part_fields();

/// Whether a control takes whole numbers only.
bool takes_whole_numbers(const ControlSpec& control);
/// What to do where it was given another one.
inline constexpr const char* kGiveWholeNumber = "it takes whole numbers only";

/// `format` of any of our files: must be there and be 1.
void check_format(const Value::Table& table, const Source& file, ErrorList& errors);

/// The table called `section` as named entries that are tables themselves; `example` shows one in the
/// message.
std::vector<EntrySpec> read_entries(const Value::Table& table, const std::string& section,
                                    const std::string& example, ErrorList& errors);

/// The table called `section`; nullptr if it is not there or, with an error, not a table.
const Value::Table* read_section(const Value::Table& table, const std::string& section, ErrorList& errors);

}  // namespace tactus
