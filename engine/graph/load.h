#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "engine/core/error.h"
#include "engine/graph/spec.h"
#include "engine/graph/value.h"

namespace tactus {

/// A TOML file as plain data. Errors: BadFile, Syntax (one: the parser stops at the first).
Result<Value::Table> load_toml(const std::filesystem::path& file);
Result<Value::Table> parse_toml(std::string_view text, const std::string& file_name);

/// Reads an instrument, plant or part, and every file that it uses. `root` is the folder that `use` and other
/// paths may not leave (empty: the file's own folder). Every mistake comes back, in file order: unknown
/// sections and keys, wrong types, names that are not names or given twice, files that use themselves.
Checked<std::shared_ptr<const GraphSpec>> load_graph(const std::filesystem::path& file,
                                                     const std::filesystem::path& root = {});
/// The same from text; `file_name` stands in messages, and relative paths start at its folder.
Checked<std::shared_ptr<const GraphSpec>> parse_graph(std::string_view text, const std::string& file_name,
                                                      const std::filesystem::path& root = {});

}  // namespace tactus
