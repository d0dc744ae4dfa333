#include "engine/core/dimension.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "engine/core/decibels.h"
#include "engine/core/units.h"

namespace tactus {
namespace {

constexpr double kMostExponent = 99;  // nothing physical has more

struct Symbol {
  std::string_view name;
  Unit unit;
};

// Dimension order: metre, kilogram, second, ampere.
constexpr std::array kSymbols = {
    Symbol{"m", {{1, 0, 0, 0}, 1.0, false}},
    Symbol{"cm", {{1, 0, 0, 0}, 1e-2, false}},
    Symbol{"mm", {{1, 0, 0, 0}, 1e-3, false}},
    Symbol{"um", {{1, 0, 0, 0}, 1e-6, false}},
    Symbol{"kg", {{0, 1, 0, 0}, 1.0, false}},
    Symbol{"g", {{0, 1, 0, 0}, 1e-3, false}},
    Symbol{"mg", {{0, 1, 0, 0}, 1e-6, false}},
    Symbol{"s", {{0, 0, 1, 0}, 1.0, false}},
    Symbol{"ms", {{0, 0, 1, 0}, 1e-3, false}},
    Symbol{"us", {{0, 0, 1, 0}, 1e-6, false}},
    Symbol{"Hz", {{0, 0, -1, 0}, 1.0, false}},
    Symbol{"kHz", {{0, 0, -1, 0}, 1e3, false}},
    Symbol{"MHz", {{0, 0, -1, 0}, 1e6, false}},
    Symbol{"N", {{1, 1, -2, 0}, 1.0, false}},
    Symbol{"mN", {{1, 1, -2, 0}, 1e-3, false}},
    Symbol{"kN", {{1, 1, -2, 0}, 1e3, false}},
    Symbol{"J", {{2, 1, -2, 0}, 1.0, false}},
    Symbol{"mJ", {{2, 1, -2, 0}, 1e-3, false}},
    Symbol{"W", {{2, 1, -3, 0}, 1.0, false}},
    Symbol{"mW", {{2, 1, -3, 0}, 1e-3, false}},
    Symbol{"Pa", {{-1, 1, -2, 0}, 1.0, false}},
    Symbol{"A", {{0, 0, 0, 1}, 1.0, false}},
    Symbol{"mA", {{0, 0, 0, 1}, 1e-3, false}},
    Symbol{"V", {{2, 1, -3, -1}, 1.0, false}},
    Symbol{"mV", {{2, 1, -3, -1}, 1e-3, false}},
    Symbol{"ohm", {{2, 1, -3, -2}, 1.0, false}},
    Symbol{"kohm", {{2, 1, -3, -2}, 1e3, false}},
    Symbol{"Mohm", {{2, 1, -3, -2}, 1e6, false}},
    Symbol{"H", {{2, 1, -2, -2}, 1.0, false}},
    Symbol{"mH", {{2, 1, -2, -2}, 1e-3, false}},
    Symbol{"uH", {{2, 1, -2, -2}, 1e-6, false}},
    Symbol{"F", {{-2, -1, 4, 2}, 1.0, false}},
    Symbol{"uF", {{-2, -1, 4, 2}, 1e-6, false}},
    Symbol{"nF", {{-2, -1, 4, 2}, 1e-9, false}},
    Symbol{"C", {{0, 0, 1, 1}, 1.0, false}},
    Symbol{"pC", {{0, 0, 1, 1}, 1e-12, false}},
    Symbol{"T", {{0, 1, -2, -1}, 1.0, false}},
    Symbol{"rad", {{}, 1.0, false}},
    Symbol{"mrad", {{}, 1e-3, false}},
    Symbol{"deg", {{}, kPi / 180.0, false}},
    Symbol{"dB", {{}, 1.0, true}},
    Symbol{"dBFS", {{}, 1.0, true}},
    Symbol{"%", {{}, 1e-2, false}},
    Symbol{"rpm", {{0, 0, -1, 0}, 1.0 / 60.0, false}},
};

bool same(double a, double b) { return std::abs(a - b) < 1e-9; }

const Symbol* find_symbol(std::string_view name) {
  for (const auto& symbol : kSymbols)
    if (symbol.name == name) return &symbol;
  return nullptr;
}

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// "m^1.5": one symbol with an optional exponent.
std::optional<Unit> parse_factor(std::string_view text) {
  const auto caret = text.find('^');
  const auto* symbol = find_symbol(text.substr(0, caret));
  if (symbol == nullptr) return std::nullopt;
  Unit unit = symbol->unit;
  if (caret == std::string_view::npos) return unit;
  const auto exponent = parse_number(text.substr(caret + 1));
  if (!exponent || std::abs(*exponent) > kMostExponent || unit.decibel) return std::nullopt;
  unit.dimension = unit.dimension.pow(*exponent);
  unit.factor = std::pow(unit.factor, *exponent);
  return unit;
}

void append_power(std::string& text, std::string_view symbol, double exponent) {
  if (!text.empty()) text += ' ';
  text += symbol;
  if (same(exponent, 1)) return;
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, exponent);
  (void)error;
  text += '^';
  text.append(digits, end);
}

constexpr std::string_view kFullScale = "full scale";

bool in_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

/// Length of "m^1.5", "ms" or "%" at the beginning of `text`; 0 if it does not begin with one symbol.
std::size_t symbol_length(std::string_view text) {
  if (text.starts_with('%')) return 1;
  const auto word_end = std::find_if_not(text.begin(), text.end(), in_word);
  const auto length = static_cast<std::size_t>(word_end - text.begin());
  if (!is_unit_symbol(text.substr(0, length))) return 0;
  if (length == text.size() || text[length] != '^') return length;
  double exponent = 0;
  const auto parsed = std::from_chars(text.data() + length + 1, text.data() + text.size(), exponent);
  return parsed.ec == std::errc{} ? static_cast<std::size_t>(parsed.ptr - text.data()) : length;
}

}  // namespace

bool Dimension::operator==(const Dimension& other) const {
  return same(metre, other.metre) && same(kilogram, other.kilogram) && same(second, other.second) &&
         same(ampere, other.ampere);
}
Dimension Dimension::operator*(const Dimension& o) const {
  return {metre + o.metre, kilogram + o.kilogram, second + o.second, ampere + o.ampere};
}
Dimension Dimension::operator/(const Dimension& o) const { return *this * o.pow(-1); }
Dimension Dimension::pow(double e) const { return {metre * e, kilogram * e, second * e, ampere * e}; }

std::string to_string(const Dimension& d) {
  if (d.plain()) return "";
  // Units with a name of their own first; then mechanical ones as newtons over metres and seconds.
  static constexpr std::string_view kNamed[] = {"m", "kg", "s",   "Hz", "N", "J", "W",
                                                "A", "V",  "ohm", "H",  "F", "C", "T"};
  for (const auto name : kNamed)
    if (find_symbol(name)->unit.dimension == d) return std::string{name};
  static constexpr std::string_view kCompound[] = {"m/s", "m/s^2", "N/m", "N s/m", "s/m",
                                                   "N s", "T m",   "V/A", "1/m"};
  for (const auto name : kCompound)
    if (parse_unit(name)->dimension == d) return std::string{name};
  std::string above, below;
  Dimension rest = d;
  if (same(d.kilogram, 1) && d.second <= -2 + 1e-9 && same(d.ampere, 0)) {
    above = "N";
    rest = d / find_symbol("N")->unit.dimension;
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

double Unit::to_si(double number) const { return decibel ? amplitude_from_db(number) : number * factor; }
double Unit::from_si(double si) const { return decibel ? 20.0 * std::log10(si) : si / factor; }

std::optional<Unit> parse_unit(std::string_view text) {
  text = trim(text);
  if (text.empty() || text == "full scale" || text == "1") return Unit{};
  Unit unit;
  bool divide = false;
  bool first = true;
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
    }
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

bool is_unit_symbol(std::string_view word) { return find_symbol(word) != nullptr; }

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

std::optional<ParsedQuantity> parse_quantity(std::string_view text) {
  text = trim(text);
  std::size_t end = 0;
  // The longest prefix that is a number: "5e6 N" must not stop at the 'e'.
  std::optional<double> number;
  double value = 0;
  const std::size_t sign = !text.empty() && text.front() == '+' ? 1 : 0;
  const auto parsed = std::from_chars(text.data() + sign, text.data() + text.size(), value);
  if (parsed.ec == std::errc{} && std::isfinite(value)) {
    number = value;
    end = static_cast<std::size_t>(parsed.ptr - text.data());
  }
  if (!number) return std::nullopt;
  const auto unit = parse_unit(text.substr(end));
  if (!unit) return std::nullopt;
  const double si = unit->to_si(*number);
  if (!std::isfinite(si)) return std::nullopt;
  return ParsedQuantity{si, *unit};
}

}  // namespace tactus
