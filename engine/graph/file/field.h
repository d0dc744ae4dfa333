#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/named.h"
#include "engine/core/units.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/semantics/interval.h"

// Thread: [control]

namespace tactus {

/// The latest time that a file may name: a day.
inline constexpr double kLongestTime_s = 86400;

struct SectionType;
struct EntrySpec;

/// One key of a section of a file, or one setting of a node. Reader, unknown-key errors, ranges, JSON Schema
/// and reference come from it.
struct FieldType {
  enum class Kind {
    Choice,     ///< a string, one of `choices`
    Integer,    ///< from `low` to `high`
    Quantity,   ///< from `low` to `high` (SI); the unit is `choices[0]` if there
    Flag,       ///< true or false
    Text,       ///< not empty
    File,       ///< path of a file, relative to the graph file, never outside the instruments' folder
    Points,     ///< [[x, y], …], quantities allowed; the units are those named in `choices` (x, then y)
    Numbers,    ///< [a, b, …], quantities allowed; the unit is `choices[0]` if there
    Names,      ///< [node, node, …]: nodes whose phase delay is compensated (see NodeType::compensation)
    Unit,       ///< text that is a unit
    Prose,      ///< for people
    Any,        ///< a quantity of any unit
    Signal,     ///< an expression, a number or lanes
    Range,      ///< two quantities, the lower one first
    Channels,   ///< whole numbers or "none"
    Format,     ///< 1
    Section,    ///< keys as in `inside`
    Entries,    ///< free names, each a table with keys as in `inside`
    Settings,   ///< free names, each a quantity
    Reference,  ///< free names, each as the schema's definition `choices[0]`; read by code of its own
  };
  std::string name;
  Kind kind = Kind::Text;
  std::string doc;
  std::vector<std::string> choices{};  ///< of a choice; else units: "ms", "N/m", or "=unit" (of that setting)
  std::string fallback{};              ///< what it is if left out, as in a file
  bool required = false;
  double low = -kUnlimited, high = kUnlimited;
  const SectionType* inside = nullptr;
  std::string only{};  ///< belongs only to this `kind` of the section

  /// Its unit as text; "" for a plain number.
  std::string unit() const { return kind == Kind::Choice || choices.empty() ? std::string{} : choices[0]; }
};

/// The value of a setting.
struct SettingValue {
  std::string text;                               ///< Choice, Text, Unit; File: the resolved path
  double number = 0;                              ///< Integer, Quantity (SI), Flag
  std::vector<std::pair<double, double>> points;  ///< Points, SI
  std::vector<double> numbers;                    ///< Numbers, SI
  std::vector<std::string> names;                 ///< Names
  bool given = false;
  bool operator==(const SettingValue&) const = default;
};

/// The keys of a table of a file.
struct SectionType {
  std::string doc;
  std::vector<FieldType> fields;
  std::vector<std::string> one_of{};    ///< at least one of these is required
  std::vector<std::string> together{};  ///< all of these or none

  /// Which must exist.
  const FieldType& operator[](std::string_view name) const { return *find_named(fields, name); }
  std::vector<std::string> keys() const { return names_of(fields); }
};

// Rows of a section.
inline FieldType field(std::string name, FieldType::Kind kind, std::string doc, std::string fallback = {}) {
  return {std::move(name), kind, std::move(doc), {}, std::move(fallback)};
}
inline FieldType text_field(std::string name, std::string doc, std::string fallback = {}) {
  return field(std::move(name), FieldType::Kind::Text, std::move(doc), std::move(fallback));
}
inline FieldType about_field() { return text_field("about", "for people"); }
inline FieldType within(double low, double high, FieldType field) {
  return field.low = low, field.high = high, field;
}
inline FieldType quantity_field(std::string name, std::string unit, double low, double high, std::string doc,
                                std::string fallback = {}) {
  return within(low, high,
                {std::move(name), FieldType::Kind::Quantity, std::move(doc), {unit}, std::move(fallback)});
}
inline FieldType whole_field(std::string name, double low, double high, std::string doc,
                             std::string fallback = {}) {
  return within(low, high,
                field(std::move(name), FieldType::Kind::Integer, std::move(doc), std::move(fallback)));
}
inline FieldType choice_field(std::string name, std::vector<std::string> choices, std::string doc,
                              std::string fallback = {}) {
  return {std::move(name), FieldType::Kind::Choice, std::move(doc), std::move(choices), std::move(fallback)};
}
inline FieldType entries_field(std::string name, const SectionType& inside, std::string doc) {
  return {.name = std::move(name), .kind = FieldType::Kind::Entries, .doc = doc, .inside = &inside};
}
inline FieldType section_field(std::string name, const SectionType& inside) {
  return {.name = std::move(name), .kind = FieldType::Kind::Section, .doc = inside.doc, .inside = &inside};
}
inline FieldType required(FieldType field) { return field.required = true, field; }
inline FieldType only(std::string kind, FieldType field) { return field.only = std::move(kind), field; }
std::vector<FieldType> joined(std::vector<FieldType> fields, const std::vector<FieldType>& more);

/// Reads one table as its section says; each error is reported with its place. What is left out or wrong is
/// nothing. The table and the section must outlive it.
class FieldReader {
 public:
  /// Reports unknown keys, those that belong to another `kind`, and an `about` that is no text.
  /// `owner` ("delay 'a'") names the owner of the keys in messages.
  FieldReader(const Value::Table& table, const SectionType& section, ErrorList& errors,
              std::string owner = {});
  /// Also reports what `section` requires and the table lacks; `owner` ("port 'arm'") stands at `at`.
  FieldReader(const Value::Table& table, const SectionType& section, ErrorList& errors,
              const std::string& owner, const Source& at);
  /// The same of an entry, with `what` it is: "port". One that is broken lacks nothing.
  FieldReader(const EntrySpec& entry, const SectionType& section, ErrorList& errors, const std::string& what);
  /// Reports nothing: for tables whose keys were checked before.
  enum Checked { kKeysChecked };
  FieldReader(const Value::Table& table, std::span<const FieldType> fields, ErrorList& errors, Checked,
              std::string owner = {})
      : table_(table), fields_(fields), errors_(errors), owner_(std::move(owner)) {}

  const Value* value(std::string_view key) const { return find(table_, key); }
  bool has(std::string_view key) const { return value(key) != nullptr; }
  /// Where a key is, else `otherwise`.
  Source at(std::string_view key, const Source& otherwise) const;

  std::string text(std::string_view key);
  /// Plain if it is left out; nothing after an error.
  std::optional<Unit> unit(std::string_view key);
  /// Of a quantity or a whole number; `most` lowers the highest that the section allows.
  std::optional<double> number(std::string_view key, double most = kUnlimited);
  std::optional<QuantityValue> any(std::string_view key);
  bool flag(std::string_view key);
  /// Place in the choices.
  std::optional<int> choice(std::string_view key);
  /// Two quantities of this unit, the lower one first.
  std::optional<Interval> range(std::string_view key, const Unit& unit);
  /// `from` and `to` within `duration` (0: a day), in this order.
  std::pair<std::optional<double>, std::optional<double>> window(Seconds duration);

 private:
  void report_missing(const SectionType& section, const std::string& owner, const Source& at);

  const Value::Table& table_;
  std::span<const FieldType> fields_;
  ErrorList& errors_;
  std::string owner_;
};

}  // namespace tactus
