#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/semantics/interval.h"

// Thread: [control]

namespace tactus {

/// The latest time that a file may name: a day.
inline constexpr double kLongestTime_s = 86400;

struct SectionType;

/// One key of a section of a file. Reader, unknown-key errors, ranges, JSON Schema and reference come from
/// it.
struct FieldType {
  enum class Kind {
    Text,       ///< not empty
    Prose,      ///< for people
    Quantity,   ///< of `unit`, from `low` to `high` (SI)
    Any,        ///< a quantity of any unit
    Signal,     ///< an expression, a number or lanes
    Whole,      ///< from `low` to `high`
    Flag,       ///< true or false
    Choice,     ///< one of `choices`
    Range,      ///< two quantities, the lower one first
    Points,     ///< list of such pairs
    Channels,   ///< whole numbers or "none"
    Format,     ///< 1
    Section,    ///< keys as in `inside`
    Entries,    ///< free names, each a table with keys as in `inside`
    Settings,   ///< free names, each a quantity
    Reference,  ///< free names, each as the schema's definition `unit`; read by code of its own
  };
  std::string key;
  Kind kind = Kind::Text;
  std::string doc;
  std::string unit{};
  double low = -kUnlimited, high = kUnlimited;
  std::string fallback{};  ///< what it is if left out, as in a file
  std::vector<std::string> choices{};
  const SectionType* inside = nullptr;
  bool required = false;
  std::string only{};  ///< belongs only to this `kind` of the section
};

/// The keys of a table of a file.
struct SectionType {
  std::string doc;
  std::vector<FieldType> fields;
  std::vector<std::string> one_of{};    ///< at least one of these is required
  std::vector<std::string> together{};  ///< all of these or none

  /// Which must exist.
  const FieldType& operator[](std::string_view key) const;
  std::vector<std::string> keys() const;
};

// Rows of a section.
FieldType text_field(std::string key, std::string doc, std::string fallback = {});
FieldType quantity_field(std::string key, std::string unit, double low, double high, std::string doc,
                         std::string fallback = {});
FieldType whole_field(std::string key, double low, double high, std::string doc, std::string fallback = {});
FieldType choice_field(std::string key, std::vector<std::string> choices, std::string doc,
                       std::string fallback = {});
FieldType section_field(std::string key, const SectionType& inside);
FieldType entries_field(std::string key, const SectionType& inside, std::string doc);
FieldType field(std::string key, FieldType::Kind kind, std::string doc);
FieldType required(FieldType field);
FieldType only(std::string kind, FieldType field);
FieldType about_field();
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
  FieldReader(const Value::Table& table, const SectionType& section, ErrorList& errors, Checked,
              std::string owner = {})
      : table_(table), section_(section), errors_(errors), owner_(std::move(owner)) {}

  const Value* value(std::string_view key) const { return find(table_, key); }
  bool has(std::string_view key) const { return value(key) != nullptr; }
  /// Where a key is, else `otherwise`.
  Source at(std::string_view key, const Source& otherwise) const;

  std::string text(std::string_view key);
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
  void report_missing(const std::string& owner, const Source& at);

  const Value::Table& table_;
  const SectionType& section_;
  ErrorList& errors_;
  std::string owner_;
};

}  // namespace tactus
