#pragma once
// Thread: [control]

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
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
  /// A key that earlier versions did not write.
  template <class T>
  void later(const char* key, const T& value) {
    (*this)(key, value);
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

/// A key that is missing, of another type, or a number that its type cannot hold.
struct JsonKeyError : std::invalid_argument {
  explicit JsonKeyError(const std::string& key)
      : std::invalid_argument{"'" + key + "' is missing or wrong"} {}
};

/// Reads from the object `json`. Throws JsonKeyError, and std::exception where it is no object.
struct JsonReader {
  const json_fields::Json& json;

  template <class T>
  void operator()(const char* key, T& value) const {
    read_key(key, value);
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value) const {
    if (json.contains(key)) read_key(key, value.emplace());
  }
  template <class T>
  void later(const char* key, T& value) const {
    if (json.contains(key)) read_key(key, value);
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
    } else if constexpr (std::integral<T> && !std::same_as<T, bool>) {
      value = whole<T>(json);
    } else if constexpr (std::same_as<T, double>) {
      value = json.is_null() ? std::numeric_limits<double>::infinity() : json.template get<double>();
    } else {
      json.get_to(value);
    }
  }

 private:
  template <class T>
  void read_key(const char* key, T& value) const try {
    read(json.at(key), value);
  } catch (const JsonKeyError&) {
    throw;
  } catch (const std::exception&) {
    throw JsonKeyError{key};
  }
  template <class T>
  static T whole(const json_fields::Json& json) {
    const bool fits = json.is_number_unsigned()
                          ? std::in_range<T>(json.get<std::uint64_t>())
                          : json.is_number_integer() && std::in_range<T>(json.get<std::int64_t>());
    if (!fits) throw std::out_of_range{"no whole number that fits"};
    return json.get<T>();
  }
};

}  // namespace tactus
