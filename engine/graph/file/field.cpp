#include "engine/graph/file/field.h"

#include <algorithm>
#include <cmath>

#include "engine/graph/file/spec.h"

namespace tactus {
namespace {

std::string quoted(const FieldType& field) {
  return field.kind == FieldType::Kind::Section ? "[" + field.name + "]" : "'" + field.name + "'";
}

std::optional<double> read_whole(const Value& value, const FieldType& field, double high, ErrorList& errors,
                                 const std::string& owner) {
  const auto* number = value.number();
  const bool whole = number != nullptr && std::floor(*number) == *number;
  if (whole && *number >= field.low && *number <= high) return *number;
  errors.add(number ? Errc::OutOfRange : Errc::WrongType, value.at,
             key_of(field.name, owner) +
                 (whole ? " cannot be " + short_number(*number) : std::string{" must be a whole number"}),
             std::isinf(high) ? "write it without quotes and without a decimal point"
                              : "give one from " + std::to_string(std::llround(field.low)) + " to " +
                                    std::to_string(std::llround(high)));
  return std::nullopt;
}

}  // namespace

std::vector<FieldType> joined(std::vector<FieldType> fields, const std::vector<FieldType>& more) {
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

FieldReader::FieldReader(const Value::Table& table, const SectionType& section, ErrorList& errors,
                         std::string owner)
    : FieldReader(table, section.fields, errors, kKeysChecked, std::move(owner)) {
  const auto* kind = find(table, "kind");
  const auto* chosen = kind != nullptr ? kind->text() : nullptr;
  std::vector<std::string> known;
  const bool decides =
      chosen != nullptr && std::any_of(section.fields.begin(), section.fields.end(),
                                       [&](auto& f) { return !f.only.empty() && f.only == *chosen; });
  for (const auto& field : section.fields)
    if (!decides || field.only.empty() || field.only == *chosen) known.push_back(field.name);
  errors.unknown_keys(table, known, owner_);
  if (has("about")) text("about");
}

FieldReader::FieldReader(const Value::Table& table, const SectionType& section, ErrorList& errors,
                         const std::string& owner, const Source& at)
    : FieldReader(table, section, errors) {
  report_missing(section, owner, at);
}

FieldReader::FieldReader(const EntrySpec& entry, const SectionType& section, ErrorList& errors,
                         const std::string& what)
    : FieldReader(entry.fields, section, errors) {
  if (!entry.broken) report_missing(section, what + " '" + entry.name + "'", entry.at);
}

void FieldReader::report_missing(const SectionType& section, const std::string& owner, const Source& at) {
  const auto missing = [&](const std::string& keys, const std::string& remedy) {
    errors_.add(Errc::Missing, at, owner + " lacks " + keys, remedy);
  };
  const auto given = [this](const std::string& key) { return has(key); };
  for (const auto& field : section.fields) {
    // Those two are checked by code of their own.
    if (!field.required || field.kind == FieldType::Kind::Format ||
        field.kind == FieldType::Kind::Reference || given(field.name))
      continue;
    const bool few = field.kind == FieldType::Kind::Choice && field.choices.size() < 6;
    missing(quoted(field), "give " + quoted(field) + ": " + field.doc +
                               (field.unit().empty() ? "" : ", in " + field.unit()) +
                               (few ? ", one of " + listed(field.choices) : ""));
  }
  const auto &one_of = section.one_of, &together = section.together;
  if (!one_of.empty() && std::none_of(one_of.begin(), one_of.end(), given))
    missing(listed(one_of), "give at least one of them");
  if (std::any_of(together.begin(), together.end(), given))
    for (const auto& key : together)
      if (!has(key)) missing("'" + key + "'", "give both " + listed(together) + ", or neither");
}

Source FieldReader::at(std::string_view key, const Source& otherwise) const {
  const auto* found = value(key);
  return found != nullptr ? found->at : otherwise;
}

std::string FieldReader::text(std::string_view key) { return errors_.text(table_, key, owner_); }

std::optional<Unit> FieldReader::unit(std::string_view key) {
  constexpr const char* kUnits = "write units as \"m/s\", \"N/m\", \"ms\", \"dB\" or \"full scale\"";
  const auto* found = value(key);
  if (found == nullptr) return Unit{};
  const auto* text = found->text();
  const auto unit = text != nullptr ? parse_unit(*text) : std::nullopt;
  if (text == nullptr)
    errors_.add(Errc::WrongType, found->at, key_of(key, owner_) + " must be a string, not " + found->kind(),
                kUnits);
  else if (!unit)
    errors_.add(Errc::UnknownName, found->at, "'" + *text + "' is not a unit",
                meant_unit(*text).empty() ? kUnits : "did you mean " + meant_unit(*text) + "?");
  return unit;
}

std::optional<double> FieldReader::number(std::string_view key, double most) {
  const auto& field = *find_named(fields_, key);
  const double high = std::min(field.high, most);
  const auto* found = value(key);
  if (found == nullptr) return std::nullopt;
  if (field.kind == FieldType::Kind::Integer) return read_whole(*found, field, high, errors_, owner_);
  const auto unit = parse_unit(field.unit()).value_or(Unit{});
  const auto number = read_quantity(*found, unit, field.name);
  if (errors_.keep(number) == nullptr) return std::nullopt;
  if (*number >= field.low && *number <= high) return *number;
  errors_.add(Errc::OutOfRange, found->at, key_of(key, owner_) + " cannot be " + in_unit(*number, unit),
              limits_text(field.low, high, unit));
  return std::nullopt;
}

std::optional<QuantityValue> FieldReader::any(std::string_view key) {
  if (!has(key)) return std::nullopt;
  const auto quantity = read_quantity(*value(key));
  return errors_.keep(quantity) == nullptr ? std::nullopt : std::optional{*quantity};
}

bool FieldReader::flag(std::string_view key) {
  const auto* found = value(key);
  if (found == nullptr) return false;
  if (found->flag() == nullptr)
    errors_.add(Errc::WrongType, found->at,
                key_of(key, owner_) + " must be true or false, not " + found->kind(),
                "write " + std::string{key} + " = true");
  return found->flag() != nullptr && *found->flag();
}

std::optional<int> FieldReader::choice(std::string_view key) {
  const auto* found = value(key);
  const auto word = text(key);
  if (found == nullptr || found->text() == nullptr) return std::nullopt;
  const auto& choices = find_named(fields_, key)->choices;
  const auto place = std::find(choices.begin(), choices.end(), word);
  if (place != choices.end()) return static_cast<int>(place - choices.begin());
  errors_.add(Errc::UnknownName, found->at, key_of(key, owner_) + " cannot be '" + word + "'",
              suggest(word, choices));
  return std::nullopt;
}

std::optional<Interval> FieldReader::range(std::string_view key, const Unit& unit) {
  const auto* found = value(key);
  if (found == nullptr) return std::nullopt;
  const std::string name{key};
  const auto* list = found->list();
  if (list == nullptr || list->size() != 2) {
    errors_.add(Errc::WrongType, found->at, key_of(key, owner_) + " must have two limits",
                "write " + name + " = [low, high]");
    return std::nullopt;
  }
  const auto low = read_quantity((*list)[0], unit, name), high = read_quantity((*list)[1], unit, name);
  errors_.keep(low);
  errors_.keep(high);
  if (!low || !high) return std::nullopt;
  if (*low <= *high) return Interval{*low, *high};
  errors_.add(Errc::OutOfRange, found->at, key_of(key, owner_) + " has its limits in the wrong order",
              "write the lower limit first");
  return std::nullopt;
}

std::pair<std::optional<double>, std::optional<double>> FieldReader::window(Seconds duration) {
  const double end_s = duration.value > 0 ? duration.value : kLongestTime_s;
  const auto from = number("from", end_s), to = number("to", end_s);
  if (from && to && *from >= *to)
    errors_.add(Errc::OutOfRange, value("to")->at, "'to' does not come after 'from'", "swap them");
  return {from, to};
}

}  // namespace tactus
