#pragma once
// Thread: [control]

#include <algorithm>
#include <array>
#include <concepts>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// One list of a type's keys serves writing and reading: a function `fields(io, value)` beside the type calls
/// `io(key, member)` for each, in the order of the file. JSON has no infinity: null stands for it.
///
///   template <class Io, Of<Point> T>
///   void fields(Io& io, T& point) { io("x", point.x), io("y", point.y); }
template <class T, class U>
concept Of = std::same_as<std::remove_const_t<T>, U>;

struct JsonWriter;

namespace json_fields {

using Json = nlohmann::ordered_json;

template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;
template <class T>
inline constexpr bool is_quantity = requires(T quantity) {
  T{quantity.value}, quantity / quantity;
};

template <class T>
concept HasFields = requires(JsonWriter& writer, T& value) {
  fields(writer, value);
};

}  // namespace json_fields

/// Writes: `json` is the object.
struct JsonWriter {
  json_fields::Json json = json_fields::Json::object();

  template <class T>
  void operator()(const char* key, const T& value) {
    json[key] = written(value);
  }
  template <class T>
  void operator()(const char* key, const std::optional<T>& value) {
    if (value) json[key] = written(*value);
  }
  /// A key that is always the same, and not read.
  void constant(const char* key, const auto& value) { json[key] = value; }
  /// An enumerator by its place in `names`.
  void name(const char* key, auto value, const auto& names) { json[key] = names[std::size_t(value)]; }

  template <class T>
  static json_fields::Json written(const T& value) {
    if constexpr (json_fields::HasFields<const T>) {
      JsonWriter io;
      fields(io, value);
      return std::move(io.json);
    } else if constexpr (json_fields::is_quantity<T>) {
      return value.value;
    } else if constexpr (json_fields::is_vector<T>) {
      auto array = json_fields::Json::array();
      for (const auto& each : value) array.push_back(written(each));
      return array;
    } else {
      return value;
    }
  }
};

/// Reads from the object `json`. Throws std::exception for a key that is missing or of another type.
struct JsonReader {
  const json_fields::Json& json;

  template <class T>
  void operator()(const char* key, T& value) const {
    read(json.at(key), value);
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value) const {
    if (json.contains(key)) read(json.at(key), value.emplace());
  }
  void constant(const char*, const auto&) const {}
  template <class T>
  void name(const char* key, T& value, const auto& names) const {
    const auto found = std::find(std::begin(names), std::end(names), json.at(key).get<std::string>());
    if (found == std::end(names)) throw std::invalid_argument{std::string{"an unknown "} + key};
    value = static_cast<T>(found - std::begin(names));
  }

  template <class T>
  static void read(const json_fields::Json& json, T& value) {
    if constexpr (json_fields::HasFields<T>) {
      const JsonReader io{json};
      fields(io, value);
    } else if constexpr (json_fields::is_quantity<T>) {
      read(json, value.value);
    } else if constexpr (json_fields::is_vector<T>) {
      value.clear();
      for (const auto& each : json) read(each, value.emplace_back());
    } else if constexpr (std::same_as<T, double>) {
      value = json.is_null() ? std::numeric_limits<double>::infinity() : json.template get<double>();
    } else {
      json.get_to(value);
    }
  }
};

}  // namespace tactus
