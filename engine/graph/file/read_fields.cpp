#include "engine/graph/file/read_fields.h"

#include <cmath>

namespace tactus {
namespace {

Unit unit_called(const std::string& text) { return parse_unit(text).value_or(Unit{}); }

std::string in_unit(double si, const std::string& unit) {
  return short_quantity(si, unit_called(unit).dimension);
}

}  // namespace

std::optional<QuantityValue> read_any(const Value::Table& fields, std::string_view key, Mistakes& mistakes) {
  const auto* value = find(fields, key);
  if (value == nullptr) return std::nullopt;
  const auto quantity = read_quantity(*value);
  return mistakes.keep(quantity) == nullptr ? std::nullopt : std::optional{*quantity};
}

std::optional<double> read_bounded(const Value::Table& table, const std::string& key, const std::string& unit,
                                   double low, double high, Mistakes& mistakes) {
  const auto* value = find(table, key);
  if (value == nullptr) return std::nullopt;
  const auto number = read_quantity(*value, unit_called(unit), key);
  if (mistakes.keep(number) == nullptr) return std::nullopt;
  if (*number >= low && *number <= high) return *number;
  mistakes.add(Errc::OutOfRange, value->at, "'" + key + "' cannot be " + in_unit(*number, unit),
               "it runs from " + in_unit(low, unit) + " to " + in_unit(high, unit));
  return std::nullopt;
}

std::pair<std::optional<double>, std::optional<double>> read_window(const Value::Table& table,
                                                                    Seconds duration, Mistakes& mistakes) {
  const double end_s = duration.value > 0 ? duration.value : kLongestTime_s;
  const auto from = read_bounded(table, "from", "s", 0, end_s, mistakes);
  const auto to = read_bounded(table, "to", "s", 0, end_s, mistakes);
  if (from && to && *from >= *to)
    mistakes.add(Errc::OutOfRange, find(table, "to")->at, "'to' does not come after 'from'", "swap them");
  return {from, to};
}

std::optional<double> read_whole(const Value::Table& table, const std::string& key, double low, double high,
                                 Mistakes& mistakes) {
  const auto* value = find(table, key);
  if (value == nullptr) return std::nullopt;
  const auto* number = value->number();
  if (number != nullptr && std::floor(*number) == *number && *number >= low && *number <= high)
    return *number;
  const bool whole = number != nullptr && std::floor(*number) == *number;
  mistakes.add(
      number ? Errc::OutOfRange : Errc::WrongType, value->at,
      "'" + key + (whole ? "' cannot be " + short_number(*number) : "' must be a whole number"),
      "give one from " + std::to_string(std::llround(low)) + " to " + std::to_string(std::llround(high)));
  return std::nullopt;
}

}  // namespace tactus
