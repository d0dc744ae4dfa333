#pragma once

#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/spec.h"

namespace tactus {

/// The sections of one graph file, without the files that it uses. `file` has no line.
GraphSpec read_graph(const Value::Table& table, const Source& file, Mistakes& mistakes);

/// `format` of any of our files: must be there and be 1.
void check_format(const Value::Table& table, const Source& file, Mistakes& mistakes);

/// The table called `section` as named entries that are tables themselves; `example` shows one in the
/// message.
std::vector<EntrySpec> read_entries(const Value::Table& table, const std::string& section,
                                    const std::string& example, Mistakes& mistakes);

/// The table called `section`; nullptr if it is not there or, with a mistake, not a table.
const Value::Table* read_section(const Value::Table& table, const std::string& section, Mistakes& mistakes);

}  // namespace tactus
