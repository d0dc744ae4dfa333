#pragma once

// Thread: [control]

#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace tactus {

/// A place in a graph file. The file's name is shared by all that was read from it.
struct Source {
  std::shared_ptr<const std::string> file;
  int line = 0;
  int column = 0;

  /// "file:line:column", as compilers print it.
  std::string text() const {
    if (!file) return {};
    return line > 0 ? *file + ":" + std::to_string(line) + ":" + std::to_string(column) : *file;
  }
};

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
  std::string kind() const {
    static constexpr const char* kNames[] = {"a number", "true or false", "a string", "a list", "a table"};
    return kNames[data.index()];
  }
};

/// `key = value`
struct Field {
  std::string key;
  Source at;
  Value value;
};

/// The field called `key`, or nullptr.
inline const Value* find(const Value::Table& table, std::string_view key) {
  for (const auto& field : table)
    if (field.key == key) return &field.value;
  return nullptr;
}

}  // namespace tactus
