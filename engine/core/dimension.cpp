#include "engine/core/dimension.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/core/decibels.h"
#include "engine/core/parse_double.h"
#include "engine/core/units.h"

namespace tactus {
namespace {

constexpr double kMostExponent = 99;  // nothing physical has more

struct Symbol {
  std::string_view name, prefixes;
  Unit unit;
};

/// An octave in decibels of amplitude.
constexpr double kOctave_dB = 6.0205999132796239;

// Exponents of metre, kilogram, second, ampere, radian.
constexpr Symbol kSymbols[] = {
    {"m", "cmu", {{1, 0, 0, 0}}},
    {"g", "km", {{0, 1, 0, 0}, 1e-3}},
    {"s", "mu", {{0, 0, 1, 0}}},
    {"Hz", "kM", {{0, 0, -1, 0}}},
    {"N", "mk", {{1, 1, -2, 0}}},
    {"J", "m", {{2, 1, -2, 0}}},
    {"W", "m", {{2, 1, -3, 0}}},
    {"Pa", "", {{-1, 1, -2, 0}}},
    {"A", "m", {{0, 0, 0, 1}}},
    {"V", "m", {{2, 1, -3, -1}}},
    {"ohm", "kM", {{2, 1, -3, -2}}},
    {"H", "mu", {{2, 1, -2, -2}}},
    {"F", "un", {{-2, -1, 4, 2}}},
    {"C", "p", {{0, 0, 1, 1}}},
    {"T", "", {{0, 1, -2, -1}}},
    {"rad", "m", {{0, 0, 0, 0, 1}}},
    {"deg", "", {{0, 0, 0, 0, 1}, kPi / 180.0}},
    {"dB", "", {{}, 1.0, true}},
    {"dBFS", "", {{}, 1.0, true}},
    {"%", "", {{}, 1e-2}},
    {"cents", "", {{}, kOctave_dB / 1200, true}},
    {"cent", "", {{}, kOctave_dB / 1200, true}},
    {"semitones", "", {{}, kOctave_dB / 12, true}},
    {"semitone", "", {{}, kOctave_dB / 12, true}},
    {"rpm", "", {{0, 0, -1, 0}, 1.0 / 60.0}},
    {"bpm", "", {{0, 0, -1, 0}, 1.0 / 60.0}},
};
constexpr std::pair<char, double> kPrefixes[] = {{'p', 1e-12}, {'n', 1e-9}, {'u', 1e-6}, {'m', 1e-3},
                                                 {'c', 1e-2},  {'k', 1e3},  {'M', 1e6}};

bool same(double a, double b) { return std::abs(a - b) < 1e-9; }

/// Bytes of "µ" at the beginning, the micro sign or the Greek letter; 0 if there is none.
std::size_t micro_length(std::string_view text) {
  return text.starts_with("\u00B5") || text.starts_with("\u03BC") ? 2 : 0;
}

std::optional<Unit> find_symbol(std::string_view name) {
  if (const auto micro = micro_length(name); micro > 0)
    return name.size() == micro ? std::nullopt : find_symbol("u" + std::string{name.substr(micro)});
  for (const auto& [symbol, prefixes, unit] : kSymbols) {
    if (name == symbol) return unit;
    if (name.size() != symbol.size() + 1 || !name.ends_with(symbol)) continue;
    if (prefixes.find(name.front()) == prefixes.npos) continue;
    const auto* const prefix = std::ranges::find(kPrefixes, name.front(), &std::pair<char, double>::first);
    return Unit{unit.dimension, unit.factor * prefix->second, unit.decibel};
  }
  return std::nullopt;
}

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Takes the longest number off the beginning of `text`: "5e6 N" does not stop at the 'e'.
std::optional<double> take_number(std::string_view& text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = parse_double(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  text = text.substr(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// "m^1.5": one symbol with an optional exponent.
std::optional<Unit> parse_factor(std::string_view text) {
  const auto caret = text.find('^');
  auto found = find_symbol(text.substr(0, caret));
  if (!found || caret == std::string_view::npos) return found;
  Unit unit = *found;
  text.remove_prefix(caret + 1);
  const auto exponent = take_number(text);
  if (!exponent || !text.empty() || std::abs(*exponent) > kMostExponent || unit.decibel) return std::nullopt;
  unit.dimension = unit.dimension.pow(*exponent);
  unit.factor = std::pow(unit.factor, *exponent);
  return unit;
}

void append_power(std::string& text, std::string_view symbol, double exponent) {
  if (!text.empty()) text += ' ';
  text += symbol;
  if (same(exponent, 1)) return;
  char digits[32];
  text += '^';
  text.append(digits, std::to_chars(digits, digits + sizeof digits, exponent).ptr);
}

constexpr std::string_view kFullScale = "full scale";

bool in_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

/// Length of "m^1.5", "ms" or "%" at the beginning of `text`; 0 if it does not begin with one symbol.
std::size_t symbol_length(std::string_view text) {
  if (text.starts_with('%')) return 1;
  const auto word_end =
      std::find_if_not(text.begin() + static_cast<std::ptrdiff_t>(micro_length(text)), text.end(), in_word);
  const auto length = static_cast<std::size_t>(word_end - text.begin());
  if (!is_unit_symbol(text.substr(0, length))) return 0;
  if (length == text.size() || text[length] != '^') return length;
  double exponent = 0;
  const auto parsed = parse_double(text.data() + length + 1, text.data() + text.size(), exponent);
  return parsed.ec == std::errc{} ? static_cast<std::size_t>(parsed.ptr - text.data()) : length;
}

}  // namespace

bool Dimension::operator==(const Dimension& other) const {
  return same(metre, other.metre) && same(kilogram, other.kilogram) && same(second, other.second) &&
         same(ampere, other.ampere);
}
Dimension Dimension::operator*(const Dimension& o) const {
  return {metre + o.metre, kilogram + o.kilogram, second + o.second, ampere + o.ampere, radian + o.radian};
}
Dimension Dimension::operator/(const Dimension& o) const { return *this * o.pow(-1); }
Dimension Dimension::pow(double e) const {
  return {metre * e, kilogram * e, second * e, ampere * e, radian * e};
}

static bool per_second(const Dimension& d) { return d == Dimension{.second = -1}; }

bool is_angular_velocity(const Dimension& d) { return per_second(d) && same(d.radian, 1); }
bool is_frequency(const Dimension& d) { return per_second(d) && same(d.radian, 0); }

double converted(double si, const Dimension& from, const Dimension& to) {
  if (is_angular_velocity(from) && is_frequency(to)) return si / (2.0 * kPi);
  if (is_frequency(from) && is_angular_velocity(to)) return si * (2.0 * kPi);
  return si;
}

Dimension in_rotation(const Dimension& d) {
  return {2.0 * d.kilogram, d.kilogram, d.second, d.ampere, d.metre - 2.0 * d.kilogram};
}

/// Of what turns, as people write it; "" for anything else. A torque is an energy per radian.
static std::string_view rotational_name(const Dimension& d) {
  struct Name {
    std::string_view text;
    Dimension dimension;
  };
  static constexpr Name kNames[] = {{"rad", {0, 0, 0, 0, 1}},       {"rad/s", {0, 0, -1, 0, 1}},
                                    {"rad/s^2", {0, 0, -2, 0, 1}},  {"N m", {2, 1, -2, 0, -1}},
                                    {"N m/rad", {2, 1, -2, 0, -2}}, {"N m s/rad", {2, 1, -1, 0, -2}},
                                    {"kg m^2", {2, 1, 0, 0, -2}},   {"N m/A", {2, 1, -2, -1, -1}}};
  for (const auto& [text, dimension] : kNames)
    if (dimension == d && same(dimension.radian, d.radian)) return text;
  return {};
}

std::string to_string(const Dimension& d) {
  if (const auto name = rotational_name(d); !name.empty()) return std::string{name};
  if (d.plain()) return "";
  // Units with a name of their own first; then mechanical ones as newtons over metres and seconds.
  static constexpr const char* kNames[] = {"m",   "kg",    "s",   "Hz",  "N",   "J",   "W",   "A",
                                           "V",   "ohm",   "H",   "F",   "C",   "T",   "m/s", "m/s^2",
                                           "N/m", "N s/m", "s/m", "N s", "T m", "V/A", "1/m"};
  for (const auto* name : kNames)
    if (parse_unit(name)->dimension == d) return name;
  std::string above, below;
  Dimension rest = d;
  if (same(d.kilogram, 1) && d.second <= -2 + 1e-9 && same(d.ampere, 0)) {
    above = "N";
    rest = d / find_symbol("N")->dimension;
  }
  const std::pair<std::string_view, double> parts[] = {
      {"kg", rest.kilogram}, {"m", rest.metre}, {"s", rest.second}, {"A", rest.ampere}};
  for (const auto& [symbol, exponent] : parts) {
    if (same(exponent, 0)) continue;
    append_power(exponent > 0 ? above : below, symbol, std::abs(exponent));
  }
  if (above.empty()) above = "1";
  return below.empty() ? above : above + "/" + below;
}

double Unit::to_si(double number) const {
  return decibel ? amplitude_from_db(number * factor) : number * factor;
}
double Unit::from_si(double si) const { return (decibel ? 20.0 * std::log10(si) : si) / factor; }

/// "N m" is a torque, which is an energy per radian, and "kg m^2" an inertia, of which rad^2 s^-2 make an
/// energy. (What they are is for texts alone.)
static double radians_of(std::string_view first, std::string_view second) {
  if (first.ends_with('N') && second.ends_with('m')) return -1;
  if (first.ends_with('g') && second.ends_with("m^2")) return -2;
  return 0;
}

std::optional<Unit> parse_unit(std::string_view text) {
  text = trim(text);
  if (text.empty() || text == "full scale" || text == "1") return Unit{};
  Unit unit;
  bool divide = false;
  bool first = true;
  std::string_view before;
  while (!text.empty()) {
    const auto end = text.find_first_of(" */");
    const auto word = text.substr(0, end);
    if (!(first && word == "1")) {
      const auto factor = parse_factor(word);
      if (!factor) return std::nullopt;
      if (factor->decibel && !(first && end == std::string_view::npos)) return std::nullopt;
      unit.dimension = divide ? unit.dimension / factor->dimension : unit.dimension * factor->dimension;
      unit.factor = divide ? unit.factor / factor->factor : unit.factor * factor->factor;
      unit.decibel = factor->decibel;
      if (!divide) unit.dimension.radian += radians_of(before, word);
    }
    before = word;
    first = false;
    if (end == std::string_view::npos) break;
    text.remove_prefix(end);
    text = trim(text);
    if (text.front() == '/' || text.front() == '*') {
      divide = text.front() == '/' || (divide && text.front() == '*');
      text = trim(text.substr(1));
      if (text.empty()) return std::nullopt;
    }
  }
  return unit;
}

bool is_unit_symbol(std::string_view word) { return find_symbol(word).has_value(); }

std::string_view unit_prefix(std::string_view text) {
  if (text.starts_with(kFullScale) && (text.size() == kFullScale.size() || !in_word(text[kFullScale.size()])))
    return kFullScale;
  std::size_t end = 0;
  for (std::size_t next = text.starts_with("1/") ? 2 : 0; next < text.size();) {
    const auto length = symbol_length(text.substr(next));
    if (length == 0) break;
    end = next += length;
    if (next < text.size() && text[next] == '/')
      ++next;
    else
      next = std::min(text.find_first_not_of(" \t\r\n", next), text.size());
  }
  return text.substr(0, end);
}

std::string meant_unit(std::string_view text) {
  // Names and abbreviations that are written for units.
  static constexpr std::pair<std::string_view, const char*> kNames[] = {{"msec", "ms"},
                                                                        {"millisecond", "ms"},
                                                                        {"sec", "s"},
                                                                        {"second", "s"},
                                                                        {"usec", "us"},
                                                                        {"microsecond", "us"},
                                                                        {"minute", "min"},
                                                                        {"hertz", "Hz"},
                                                                        {"kilohertz", "kHz"},
                                                                        {"cps", "Hz"},
                                                                        {"meter", "m"},
                                                                        {"metre", "m"},
                                                                        {"millimeter", "mm"},
                                                                        {"millimetre", "mm"},
                                                                        {"newton", "N"},
                                                                        {"volt", "V"},
                                                                        {"ohms", "ohm"},
                                                                        {"gram", "g"},
                                                                        {"kilogram", "kg"},
                                                                        {"degree", "deg"},
                                                                        {"radian", "rad"},
                                                                        {"decibel", "dB"},
                                                                        {"semitone", "semitones"},
                                                                        {"cent", "cents"},
                                                                        {"percent", "%"}};
  std::string lower{text};
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (const auto* const named = std::ranges::find_if(
          kNames,
          [&](const auto& name) { return lower == name.first || lower == std::string{name.first} + "s"; });
      named != std::end(kNames) && parse_unit(named->second))
    return named->second;
  constexpr std::size_t kMostLetters = 8;
  std::vector<std::size_t> letters;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (std::isalpha(static_cast<unsigned char>(text[i])) != 0) letters.push_back(i);
  if (letters.empty() || letters.size() > kMostLetters) return {};
  for (unsigned upper = 0; upper < 1u << letters.size(); ++upper) {
    std::string tried{text};
    for (std::size_t i = 0; i < letters.size(); ++i) {
      const auto letter = static_cast<unsigned char>(text[letters[i]]);
      const bool is_upper = (upper >> i & 1u) != 0;
      tried[letters[i]] = static_cast<char>(is_upper ? std::toupper(letter) : std::tolower(letter));
    }
    if (parse_unit(tried)) return tried;
  }
  return {};
}

std::optional<QuantityValue> parse_quantity(std::string_view text) {
  text = trim(text);
  const auto number = take_number(text);
  const auto unit = number ? parse_unit(text) : std::nullopt;
  if (!unit) return std::nullopt;
  const double si = unit->to_si(*number);
  if (!std::isfinite(si)) return std::nullopt;
  return QuantityValue{without_denormals(si), *unit, trim(text).empty()};
}

}  // namespace tactus
