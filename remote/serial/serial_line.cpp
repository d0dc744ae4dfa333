#include "remote/serial/serial_line.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "engine/core/parse_double.h"

namespace tactus {
namespace {

constexpr std::size_t kMostValues = 16;

template <class Number>
std::optional<Number> number_of(std::string_view text, int base) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional{number} : std::nullopt;
}

std::optional<double> value_of(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = parse_double(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  return whole && std::isfinite(number) ? std::optional{number} : std::nullopt;
}

bool is_name(std::string_view text) {
  for (const unsigned char c : text)
    if (!((c < 0x80 && std::isalnum(c) != 0) || c == '_' || c == '.' || c == '-' || c == '[' || c == ']'))
      return false;
  return !text.empty();
}

/// The next word of `line`, which is taken from it.
std::string_view take_word(std::string_view& line) {
  constexpr std::string_view kBetween = " \t,";
  line.remove_prefix(std::min(line.find_first_not_of(kBetween), line.size()));
  const auto word = line.substr(0, line.find_first_of(kBetween));
  line.remove_prefix(word.size());
  return word;
}

/// The exclusive or of all bytes, as in NMEA 0183.
unsigned checksum(std::string_view bytes) {
  unsigned sum = 0;
  for (const unsigned char byte : bytes) sum ^= byte;
  return sum;
}

}  // namespace

std::optional<SerialLine> parse_serial_line(std::string_view line) {
  SerialLine parsed;
  if (const auto star = line.rfind('*'); star != line.npos) {
    const auto given = number_of<unsigned>(line.substr(star + 1), 16);
    if (!given || *given != checksum(line.substr(0, star))) return std::nullopt;
    line = line.substr(0, star);
  }
  auto word = take_word(line);
  if (word.starts_with('@')) {
    parsed.micros = number_of<std::uint32_t>(word.substr(1), 10);
    if (!parsed.micros) return std::nullopt;
    word = take_word(line);
  }
  for (; !word.empty(); word = take_word(line)) {
    const auto value = value_of(take_word(line));
    if (!is_name(word) || !value || parsed.values.size() == kMostValues) return std::nullopt;
    parsed.values.push_back({std::string{word}, *value});
  }
  return parsed.values.empty() ? std::nullopt : std::optional{std::move(parsed)};
}

}  // namespace tactus
