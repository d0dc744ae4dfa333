#include "engine/graph/file/quantity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>

#include "engine/core/parse_double.h"

namespace tactus {
namespace {

/// An example of a quantity of this dimension, to show what was wanted.
std::string example_of(const Dimension& dimension) {
  static constexpr std::array kExamples = {"15 ms",    "440 Hz",    "12 mm", "0.5 m/s", "1.5 N",
                                           "1000 N/m", "0.1 N s/m", "12 g",  "6 ohm",   "0.8 mH",
                                           "10 V",     "6 T m",     "0.2 A"};
  for (const auto* text : kExamples)
    if (parse_quantity(text)->unit.dimension == dimension) return std::string{"\""} + text + "\"";
  return dimension.plain() ? "a number without a unit, such as 0.5" : "a quantity in " + to_string(dimension);
}

/// The text after the leading number, whatever its size; nullopt: the text does not begin with a number.
std::optional<std::string_view> behind_number(std::string_view text) {
  const auto start = std::min(text.find_first_not_of(" +"), text.size());
  double value = 0;
  const auto number = parse_double(text.data() + start, text.data() + text.size(), value);
  if (number.ec == std::errc::invalid_argument) return std::nullopt;
  const auto rest = text.substr(static_cast<std::size_t>(number.ptr - text.data()));
  return rest.substr(std::min(rest.find_first_not_of(' '), rest.size()));
}

}  // namespace

std::string short_number(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", number);
  return text.data();
}

std::string short_quantity(double si, const Dimension& dimension) {
  // From small to large; the first of a dimension serves whatever is smaller.
  static constexpr std::array kUnits = {
      "us",  "ms", "s",  "um", "mm", "m",    "mg",   "g",   "kg",       "mN",      "N",    "kN",   "Hz",
      "kHz", "mJ", "J",  "mW", "W",  "mA",   "A",    "mV",  "V",        "ohm",     "kohm", "Mohm", "uH",
      "mH",  "H",  "nF", "uF", "F",  "uN m", "mN m", "N m", "mN m/rad", "N m/rad", "rad/s"};
  // A torque is no energy, and an angular velocity no frequency; an arc with radians left in it is a length.
  for (const bool strictly : {true, false}) {
    std::string text;
    for (const auto* name : kUnits) {
      const auto unit = *parse_unit(name);
      const bool radians = std::abs(unit.dimension.radian - dimension.radian) < 0.5;
      if (!(unit.dimension == dimension) || (strictly && !radians)) continue;
      const bool zero = si == 0 && unit.factor == 1;
      if (text.empty() || zero || (si != 0 && std::abs(unit.from_si(si)) >= 0.9999995))
        text = short_number(unit.from_si(si)) + " " + name;
    }
    if (!text.empty()) return text;
  }
  const auto name = to_string(dimension);
  return short_number(si) + (name.empty() ? "" : " " + name);
}

/// "dB", "cents", "semitones"
static const char* name_of_ratio(const Unit& unit) {
  for (const auto* name : {"cents", "semitones"})
    if (parse_unit(name)->factor == unit.factor) return name;
  return "dB";
}

std::string in_unit(double si, const Unit& unit) {
  if (unit.decibel) return short_number(unit.from_si(si)) + " " + name_of_ratio(unit);
  return short_quantity(si, unit.dimension);
}

std::string limits_text(double low, double high, const Unit& unit) {
  if (std::isinf(high)) return "it must be at least " + in_unit(low, unit);
  if (std::isinf(low)) return "it must be at most " + in_unit(high, unit);
  return "it runs from " + in_unit(low, unit) + " to " + in_unit(high, unit);
}

std::string unit_phrase(const Dimension& dimension) {
  const auto unit = to_string(dimension);
  return unit.empty() ? "a plain number" : "in " + unit;
}

Result<QuantityValue> read_quantity(const Value& value) {
  if (const auto* number = value.number()) return QuantityValue{*number, {}, true};
  const auto* text = value.text();
  if (text == nullptr)
    return fail(Errc::WrongType, value.at.text(), "a number with a unit cannot be " + value.kind(),
                "give a number, or a number with its unit in quotes, such as \"15 ms\"");
  const auto quantity = parse_quantity(*text);
  if (quantity) return *quantity;
  const auto unit = behind_number(*text);
  if (unit && parse_unit(*unit))
    return fail(Errc::OutOfRange, value.at.text(), "'" + *text + "' is not finite",
                "give a number below 1e300 in SI units");
  const auto meant = unit ? meant_unit(*unit) : std::string{};
  return fail(
      Errc::Syntax, value.at.text(), "'" + *text + "' is not a number with a unit",
      meant.empty() ? "write a number and its unit, such as \"15 ms\"" : "did you mean " + meant + "?");
}

Result<double> read_quantity(const Value& value, const Unit& expected, const std::string& what) {
  const auto quantity = read_quantity(value);
  if (!quantity) return tl::unexpected(quantity.error());
  if (quantity->bare) return quantity->si;
  if (quantity->unit.dimension == expected.dimension)
    return converted(quantity->si, quantity->unit.dimension, expected.dimension);
  return fail(Errc::UnitMismatch, value.at.text(),
              "'" + *value.text() + "' is " + unit_phrase(quantity->unit.dimension) + ", but '" + what +
                  "' is " + unit_phrase(expected.dimension),
              "give " + example_of(expected.dimension));
}

}  // namespace tactus
