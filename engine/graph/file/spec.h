#pragma once

// Thread: [control]

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/value.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/interval.h"

namespace tactus {

/// A named thing of a file, with its fields as written.
struct EntrySpec {
  std::string name;
  Source at;
  Value::Table fields;
  bool broken = false;  ///< its own error was reported; its meaning is unknown
};

/// An input or an output: the unit, and what else its fields mean.
struct PortSpec : EntrySpec {
  int lanes = 1;
  OutputUse use = OutputUse::Drive;
  Dimension dimension = {};
  bool unit_known = true;              ///< false: an error left it open
  std::optional<Interval> range = {};  ///< of an input: what it can give; nullopt: the file does not say

  /// The unit that the file gives; nothing if it gives none, or after an error.
  std::optional<Dimension> declared() const {
    return unit_known && find(fields, "unit") != nullptr ? std::optional{dimension} : std::nullopt;
  }
};

struct ControlSpec : EntrySpec {
  FlatControl control = {};
  bool unit_known = true;  ///< as of a port
};

struct NodeSpec : EntrySpec {
  std::string type;            ///< "" for a bare expression or a part
  std::string use;             ///< file of a part, as written
  std::optional<Value> value;  ///< the expression of `s = "x + g * loss"`
  Source type_at;
};

/// `[networks.name]` or `[worlds.name]`, with its options ("solver", "oversample") as fields.
struct NetworkSpec : EntrySpec {
  std::vector<NodeSpec> elements;  ///< name, type and fields of each element
  bool world = false;              ///< rigid bodies in space, not masses on a line

  /// As messages call it.
  const char* kind() const { return world ? "world" : "network"; }
};

/// A graph file, read once: its document. Nothing here was looked up yet.
struct GraphSpec {
  Source file;
  std::string name, about, source;
  std::vector<PortSpec> inputs, outputs;
  std::vector<ControlSpec> controls;
  std::vector<NodeSpec> nodes;
  std::vector<NetworkSpec> networks;  ///< and worlds
  std::optional<Interval> tested;     ///< system delays between which the instrument was tested [s]
  bool incomplete = false;  ///< a section could not be read: names that are not here may be declared there
  /// Files that `use` names, by the text of `use`. A file used twice is read once.
  std::map<std::string, std::shared_ptr<const GraphSpec>> parts;
};

}  // namespace tactus
