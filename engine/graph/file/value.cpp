#include "engine/graph/file/value.h"

namespace tactus {

std::string Value::kind() const {
  static constexpr const char* kNames[] = {"a number", "true or false", "a string", "a list", "a table"};
  return kNames[data.index()];
}

const Value* find(const Value::Table& table, std::string_view key) {
  for (const auto& field : table)
    if (field.key == key) return &field.value;
  return nullptr;
}

}  // namespace tactus
