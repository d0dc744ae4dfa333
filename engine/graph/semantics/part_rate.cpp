#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/instance.h"

namespace tactus {
namespace {

constexpr const char* kHowRates = "write a fraction such as \"1/16\", or a rate such as \"3 kHz\"";

/// Whether an input or a control of the part is called like this.
bool declares(const GraphSpec& part, std::string_view name) {
  const auto called = [&](const EntrySpec& entry) { return entry.name == name; };
  return std::ranges::any_of(part.inputs, called) || std::ranges::any_of(part.controls, called);
}

std::string of_part(const NodeSpec& node, const char* key) { return key_of(key, "part '" + node.name + "'"); }

/// The number below "1/"; nothing if it is no fraction.
std::optional<double> below_one(const std::string& text) {
  auto compact = text;
  std::erase(compact, ' ');
  if (!compact.starts_with("1/")) return std::nullopt;
  double number = 0;
  const char* const end = compact.data() + compact.size();
  const auto read = std::from_chars(compact.data() + 2, end, number);
  return read.ec == std::errc{} && read.ptr == end ? std::optional{number} : std::nullopt;
}

std::string in_hertz(double hertz) { return short_quantity(hertz, parse_unit("Hz")->dimension); }

/// The fractions on both sides of a rate that is none.
std::string nearest_rates(double around, double ratio) {
  const auto offer = [&](double n) { return "\"1/" + short_number(n) + "\" (" + in_hertz(around / n) + ")"; };
  const double below = std::max(1.0, std::floor(ratio));
  return "write " + offer(below) + " or " + offer(below + 1);
}

/// Frames around it for one of its own, not yet known to be a whole number; nothing after an error.
std::optional<double> read_ratio(const NodeSpec& node, const Value& value, Hertz around, ErrorList& errors) {
  if (const auto* text = value.text())
    if (const auto below = below_one(*text)) return below;
  const auto quantity = read_quantity(value);
  if (!quantity || quantity->bare || !(quantity->unit.dimension == parse_unit("Hz")->dimension)) {
    errors.add(Errc::WrongType, value.at, of_part(node, "rate") + " is not a rate", kHowRates);
    return std::nullopt;
  }
  if (!(quantity->si > 0) || quantity->si > around.value) {
    errors.add(
        Errc::OutOfRange, value.at, of_part(node, "rate") + " cannot be " + in_hertz(quantity->si),
        "the rate of a part must not exceed the " + in_hertz(around.value) + " of the enclosing graph");
    return std::nullopt;
  }
  return around.value / quantity->si;
}

int whole_ratio(const NodeSpec& node, const Value& value, Hertz around, ErrorList& errors) {
  const auto ratio = read_ratio(node, value, around, errors);
  if (!ratio) return 1;
  const double whole = std::round(*ratio);
  // Rates come as decimal numbers: 44.1 kHz / 14.7 kHz is 3 but for rounding.
  if (std::abs(*ratio - whole) > 1e-9 * *ratio || whole < 1) {
    errors.add(Errc::OutOfRange, value.at,
               of_part(node, "rate") + " is not the " + in_hertz(around.value) +
                   " of the enclosing graph divided by a whole number",
               nearest_rates(around.value, *ratio));
    return 1;
  }
  if (whole > PartRate::kSlowest) {
    errors.add(Errc::OutOfRange, value.at, of_part(node, "rate") + " is too low",
               "give at least \"1/" + std::to_string(PartRate::kSlowest) + "\"");
    return 1;
  }
  return static_cast<int>(whole);
}

}  // namespace

PartRate read_part_rate(const NodeSpec& node, const GraphSpec& part, Hertz around, ErrorList& errors) {
  Value::Table own = node.fields;
  std::erase_if(own, [&](const Field& field) { return declares(part, field.key); });
  FieldReader fields{own, part_fields(), errors, FieldReader::kKeysChecked, "part '" + node.name + "'"};
  const auto second_choice = [&](const char* key) {
    const auto choice = fields.choice(key);
    if (choice && !fields.has("rate"))
      errors.add(Errc::Missing, fields.value(key)->at, of_part(node, key) + " has no effect without a 'rate'",
                 "give the part its own rate, or remove '" + std::string{key} + "'");
    return choice == 1;
  };
  PartRate rate;
  if (const auto* value = fields.value("rate")) rate.ratio = whole_ratio(node, *value, around, errors);
  rate.mean = second_choice("take");
  rate.line = second_choice("between");
  return rate;
}

std::vector<std::string> part_keys(const GraphSpec& part) {
  auto keys = part_fields().keys();
  std::erase_if(keys, [&](const std::string& key) { return declares(part, key); });
  return keys;
}

}  // namespace tactus
