#pragma once

// Thread: [control]

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/value.h"

namespace tactus {

/// Named things of a file with all their fields still as written; names are checked, meanings are not.
struct EntrySpec {
  std::string name;
  Source at;
  Value::Table fields;
  bool broken = false;  ///< its own error was reported; its meaning is unknown
};

struct NodeSpec : EntrySpec {
  std::string type;            ///< "" for a bare expression or a part
  std::string use;             ///< file of a part, as written
  std::optional<Value> value;  ///< the expression of `s = "x + g * loss"`
  Source type_at;
};

/// `[networks.name]`: its options ("solver", "oversample") and its elements, as written.
struct NetworkSpec {
  std::string name;
  Source at;
  Value::Table options;            ///< fields that are not tables
  std::vector<NodeSpec> elements;  ///< name, type and fields of each element
  bool broken = false;             ///< it or one of its elements
};

/// A graph file, read once into plain data. Nothing here was looked up yet.
struct GraphSpec {
  Source file;
  std::string name, about, source;
  std::vector<EntrySpec> inputs, controls, outputs;
  std::vector<NodeSpec> nodes;
  std::vector<NetworkSpec> networks;
  std::optional<EntrySpec> delay;
  bool incomplete = false;  ///< a section could not be read: names that are not here may be declared there
  /// Files that `use` names, by the text of `use`. A file used twice is read once.
  std::map<std::string, std::shared_ptr<const GraphSpec>> parts;
};

}  // namespace tactus
