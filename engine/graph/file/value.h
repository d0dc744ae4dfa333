#pragma once

// Thread: [control]

#include <string>
#include <variant>
#include <vector>

#include "engine/graph/file/source.h"

namespace tactus {

struct Field;

/// A value of a graph file, as written, with its place. Whole numbers and reals are both `double`.
struct Value {
  using List = std::vector<Value>;
  using Table = std::vector<Field>;

  std::variant<double, bool, std::string, List, Table> data;
  Source at;

  const double* number() const { return std::get_if<double>(&data); }
  const bool* flag() const { return std::get_if<bool>(&data); }
  const std::string* text() const { return std::get_if<std::string>(&data); }
  const List* list() const { return std::get_if<List>(&data); }
  const Table* table() const { return std::get_if<Table>(&data); }
  /// "a number", "a list": for messages.
  std::string kind() const;
};

/// `key = value`
struct Field {
  std::string key;
  Source at;
  Value value;
};

/// The field called `key`, or nullptr.
const Value* find(const Value::Table& table, std::string_view key);

}  // namespace tactus
