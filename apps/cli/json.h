#pragma once
// Thread: [control]

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "engine/core/files.h"

namespace tactus::app {

using Json = nlohmann::ordered_json;

/// null is what is not known.
template <class T>
Json known(bool is_known, const T& value) {
  return is_known ? Json(value) : Json(nullptr);
}
template <class T>
Json known(const std::optional<T>& value) {
  return known(value.has_value(), value.value_or(T{}));
}

/// An array of what `convert` makes of each item.
template <class List, class Convert>
Json list_of(const List& list, Convert convert) {
  Json json = Json::array();
  for (const auto& item : list) json.push_back(convert(item));
  return json;
}

inline Json errors_json(const std::vector<Error>& errors) {
  return list_of(errors, [](const Error& one) {
    return Json{{"where", one.where}, {"what", one.what}, {"remedy", one.remedy}};
  });
}

/// Errors: BadFile.
inline Status write_json(const std::filesystem::path& file, const Json& json) {
  return write_file(file, json.dump(2) + "\n");
}
inline void print_json(const Json& json) { fmt::print("{}\n", json.dump(2)); }

}  // namespace tactus::app
