#include "export/number.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "engine/core/named.h"

namespace tactus {
namespace {

constexpr std::array kTypes = {
    NumberType{"double", "double", "", "", true, 8}, NumberType{"float", "float", "f", "f", false, 4},
    NumberType{"q31", "int32_t", "", "", false, 4, 32}, NumberType{"q16", "int16_t", "", "", false, 2, 16}};

/// Those of math.h that kernels call and that have a form for each type of number.
constexpr std::array<std::string_view, 29> kFunctions = {
    "acos", "asin",  "atan",  "atan2", "ceil",   "cos",     "exp",   "fabs",  "floor",        "fmod",
    "log",  "log10", "log1p", "log2",  "lround", "llround", "pow",   "rint",  "round",        "sin",
    "sinh", "sqrt",  "tan",   "tanh",  "trunc",  "cosh",    "expm1", "hypot", "__builtin_fma"};

constexpr auto kLeastFloat = static_cast<double>(FLT_MIN), kMostFloat = static_cast<double>(FLT_MAX);

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Whether what begins here is part of a number: exponents have signs.
bool continues_number(std::string_view code, std::size_t at, bool hexadecimal) {
  const char c = code[at];
  if (is_identifier_part(c) || c == '.') return true;
  const char before = code[at - 1];
  const bool exponent = hexadecimal ? before == 'p' || before == 'P' : before == 'e' || before == 'E';
  return (c == '+' || c == '-') && exponent;
}

std::string converted_literal(std::string_view literal, const NumberType& type) {
  const std::string text{literal};
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  const bool real = text.find_first_of(hexadecimal ? ".pP" : ".eE") != std::string::npos;
  if (!real || type.literal_suffix[0] == '\0') return text;
  const double value = std::strtod(text.c_str(), nullptr);
  if (std::isfinite(value) && value != 0 && (std::abs(value) < kLeastFloat || std::abs(value) > kMostFloat))
    return c_number(value, type);
  return text + type.literal_suffix;
}

std::string converted_word(std::string_view word, const NumberType& type) {
  if (word == "HUGE_VAL") return "INFINITY";  // of every type, also where C libraries lack HUGE_VALF
  const bool function = std::ranges::find(kFunctions, word) != kFunctions.end();
  return std::string{word} + (function ? type.function_suffix : "");
}

}  // namespace

const NumberType* find_number_type(std::string_view name) { return find_named(kTypes, name); }

std::vector<std::string> number_type_names() { return names_of(kTypes); }

std::string c_list(const std::vector<std::string>& values, std::size_t in_a_line) {
  std::string text = "{";
  for (std::size_t i = 0; i < values.size(); ++i)
    text += (i == 0 ? "" : i % in_a_line == 0 ? ",\n    " : ", ") + values[i];
  return text + "}";
}

std::string c_number(double value, const NumberType& type) {
  const bool narrow = type.literal_suffix[0] != '\0';
  if (narrow && value != 0 && std::abs(value) < kLeastFloat) value = std::copysign(kLeastFloat, value);
  if (!std::isfinite(value) || (narrow && std::abs(value) > kMostFloat))
    return std::isnan(value) ? "NAN" : std::string{value < 0 ? "-" : ""} + "INFINITY";
  std::array<char, 64> text;
  const auto end = narrow
                       ? std::to_chars(text.data(), text.data() + text.size(), static_cast<float>(value)).ptr
                       : std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  std::string number(text.data(), end);
  if (number.find_first_of(".e") == std::string::npos) number += ".0";
  return number + type.literal_suffix;
}

std::string with_numbers(std::string_view text, const NumberType& type) {
  std::string result;
  const auto convert = [&](std::string_view code) {
    for (std::size_t at = 0; at < code.size();) {
      const bool number =
          is_digit(code[at]) || (code[at] == '.' && at + 1 < code.size() && is_digit(code[at + 1]));
      if (!number && !is_identifier_start(code[at])) {
        result += code[at++];
        continue;
      }
      std::size_t end = at + 1;
      const bool hexadecimal = code.substr(at).starts_with("0x");
      while (end < code.size() &&
             (number ? continues_number(code, end, hexadecimal) : is_identifier_part(code[end])))
        ++end;
      const auto part = code.substr(at, end - at);
      result += number ? converted_literal(part, type) : converted_word(part, type);
      at = end;
    }
  };
  for_code_and_comments(text, convert, [&](std::string_view comment) { result += comment; });
  return result;
}

}  // namespace tactus
