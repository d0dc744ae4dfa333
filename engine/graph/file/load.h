#pragma once

// Thread: [control]

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/file/value.h"

namespace tactus {

/// A TOML file as plain data. Errors: BadFile, Syntax (one: the parser stops at the first).
Result<Value::Table> load_toml(const std::filesystem::path& file);
Result<Value::Table> parse_toml(std::string_view text, const std::string& file_name);
/// The text of such a file, at most as long as one may be. Errors: BadFile.
Result<std::string> read_graph_text(const std::filesystem::path& file);

/// Where a path of a graph file leads.
struct PartPath {
  std::string name;                 ///< as messages print it
  std::filesystem::path canonical;  ///< without links and dots: the same file has the same one
};

/// `folder` is the one of the file that names `use`; `root` the folder that must not be left, links resolved.
/// Errors, at `at`: OutOfRange for an absolute path and one that leads out of `root`; BadFile if there is no
/// such file.
Result<PartPath> find_part(const std::string& use, const std::filesystem::path& folder,
                           const std::filesystem::path& root, const Source& at);

/// Links and dots resolved as far as the path exists; "" is the folder we are in.
std::filesystem::path canonical_path(const std::filesystem::path& path);

/// A graph together with what is wrong with its text. What else is wrong with it (names, units, ranges) can
/// be looked up in spite of that: `compile` then reports all errors at once.
struct LoadedGraph {
  std::shared_ptr<const GraphSpec> spec;  ///< nullptr if the file cannot be read or is no TOML
  std::vector<Error> errors;              ///< by place
  /// What was read, by the path as it was opened: together they are the whole graph, whatever becomes of the
  /// files.
  std::map<std::string, std::string> texts = {};
};

/// Reads an instrument, plant or part, and every file that it uses. `root` is the folder that `use` and other
/// paths may not leave (empty: the file's own folder). Every error of the text comes back, in file order:
/// unknown sections and keys, wrong types, names that are not names or given twice, files that use
/// themselves.
LoadedGraph load_graph_leniently(const std::filesystem::path& file, const std::filesystem::path& root = {});
/// The same from text; `file_name` is the name in messages, and relative paths start at its folder.
LoadedGraph parse_graph_leniently(std::string_view text, const std::string& file_name,
                                  const std::filesystem::path& root = {});

/// A graph whose text is right.
Checked<std::shared_ptr<const GraphSpec>> load_graph(const std::filesystem::path& file,
                                                     const std::filesystem::path& root = {});

}  // namespace tactus
