#include "engine/graph/semantics/part_rate.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "engine/graph/file/quantity.h"

namespace tactus {
namespace {

constexpr const char* kHowRates = "write a fraction such as \"1/16\", or a rate such as \"3 kHz\"";

bool declares(const std::vector<EntrySpec>& entries, std::string_view name) {
  return std::any_of(entries.begin(), entries.end(), [&](const auto& entry) { return entry.name == name; });
}

/// nullptr too where the part has a wire of that name.
const Value* find_word(const NodeSpec& node, const GraphSpec& part, const char* word) {
  return declares(part.inputs, word) || declares(part.controls, word) ? nullptr : find(node.fields, word);
}

std::string of_part(const NodeSpec& node, const char* word) {
  return "'" + std::string{word} + "' of part '" + node.name + "'";
}

/// The number below "1/"; nothing if it is no fraction.
std::optional<double> below_one(const std::string& text) {
  const auto compact = [&] {
    std::string kept;
    std::copy_if(text.begin(), text.end(), std::back_inserter(kept), [](char c) { return c != ' '; });
    return kept;
  }();
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
std::optional<double> read_ratio(const NodeSpec& node, const Value& value, Hertz around, Mistakes& mistakes) {
  if (const auto* text = value.text())
    if (const auto below = below_one(*text)) return below;
  const auto quantity = read_quantity(value);
  if (!quantity || quantity->bare || !(quantity->unit.dimension == parse_unit("Hz")->dimension)) {
    mistakes.add(Errc::WrongType, value.at, of_part(node, "rate") + " is not a rate", kHowRates);
    return std::nullopt;
  }
  if (!(quantity->si > 0) || quantity->si > around.value) {
    mistakes.add(Errc::OutOfRange, value.at, of_part(node, "rate") + " cannot be " + in_hertz(quantity->si),
                 "a part runs at most at the " + in_hertz(around.value) + " around it");
    return std::nullopt;
  }
  return around.value / quantity->si;
}

int whole_ratio(const NodeSpec& node, const Value& value, Hertz around, Mistakes& mistakes) {
  const auto ratio = read_ratio(node, value, around, mistakes);
  if (!ratio) return 1;
  const double whole = std::round(*ratio);
  // Rates come as decimal numbers: 44.1 kHz / 14.7 kHz is 3 but for rounding.
  if (std::abs(*ratio - whole) > 1e-9 * *ratio || whole < 1) {
    mistakes.add(Errc::OutOfRange, value.at,
                 of_part(node, "rate") + " is not the " + in_hertz(around.value) +
                     " around it, divided by a whole number",
                 nearest_rates(around.value, *ratio));
    return 1;
  }
  if (whole > PartRate::kSlowest) {
    mistakes.add(Errc::OutOfRange, value.at, of_part(node, "rate") + " is too low",
                 "give at least \"1/" + std::to_string(PartRate::kSlowest) + "\"");
    return 1;
  }
  return static_cast<int>(whole);
}

/// Whether the word says `second`, not `first`.
bool read_choice(const NodeSpec& node, const GraphSpec& part, const char* word, const std::string& first,
                 const std::string& second, Mistakes& mistakes) {
  const auto* value = find_word(node, part, word);
  if (value == nullptr) return false;
  const auto* text = value->text();
  if (text == nullptr || (*text != first && *text != second))
    mistakes.add(Errc::UnknownName, value->at, of_part(node, word) + " cannot be this",
                 "write \"" + first + "\" or \"" + second + "\"");
  else if (find_word(node, part, "rate") == nullptr)
    mistakes.add(Errc::Missing, value->at, of_part(node, word) + " says nothing without a 'rate'",
                 "give the part a rate of its own, or leave '" + std::string{word} + "' out");
  return text != nullptr && *text == second;
}

}  // namespace

PartRate read_part_rate(const NodeSpec& node, const GraphSpec& part, Hertz around, Mistakes& mistakes) {
  PartRate rate;
  if (const auto* value = find_word(node, part, "rate"))
    rate.ratio = whole_ratio(node, *value, around, mistakes);
  rate.mean = read_choice(node, part, "take", "last", "mean", mistakes);
  rate.line = read_choice(node, part, "between", "hold", "line", mistakes);
  return rate;
}

std::vector<std::string> part_words(const GraphSpec& part) {
  std::vector<std::string> words = {"use", "voices", "about"};
  for (const auto* word : {"rate", "take", "between"})
    if (!declares(part.inputs, word) && !declares(part.controls, word)) words.emplace_back(word);
  return words;
}

}  // namespace tactus
