#pragma once
// Thread: [any]

#include <charconv>
#include <cmath>
#include <limits>

#ifndef __cpp_lib_to_chars
#include <cctype>
#include <locale>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#endif

namespace tactus {

/// A number of a file as the engine computes with it: denormals (below 2.2e-308) are 0 there, and so neither
/// a divisor nor a sign that one part takes for another.
inline double without_denormals(double x) {
  return std::abs(x) < std::numeric_limits<double>::min() ? 0.0 : x;
}

#ifdef __cpp_lib_to_chars

/// The longest decimal number at the beginning of [first, last), as std::from_chars reads it: the nearest
/// double, whatever the locale; no blanks and no '+' in front. Errors: invalid_argument, result_out_of_range.
inline std::from_chars_result parse_double(const char* first, const char* last, double& value) {
  return std::from_chars(first, last, value);
}

#else  // libc++ before version 20 has std::from_chars for integers only

/// The end of the word at the beginning of [first, last), whatever its case; `first` if it is not there.
inline const char* end_of_word(const char* first, const char* last, std::string_view word) {
  for (const char* at = first;; ++at) {
    if (word.empty()) return at;
    if (at == last || std::tolower(static_cast<unsigned char>(*at)) != word.front()) return first;
    word.remove_prefix(1);
  }
}

/// The end of the longest decimal number at the beginning of [first, last); `first` if there is none.
inline const char* end_of_number(const char* first, const char* last) {
  const auto digits = [last](const char* at) {
    while (at != last && std::isdigit(static_cast<unsigned char>(*at)) != 0) ++at;
    return at;
  };
  const char* begin = first != last && *first == '-' ? first + 1 : first;
  const char* end = digits(begin);
  bool any = end != begin;
  if (end != last && *end == '.') {
    const char* fraction = digits(end + 1);
    any = any || fraction != end + 1;
    end = fraction;
  }
  if (!any) return first;
  if (end == last || (*end != 'e' && *end != 'E')) return end;
  const char* exponent = end + 1;
  if (exponent != last && (*exponent == '-' || *exponent == '+')) ++exponent;
  return digits(exponent) == exponent ? end : digits(exponent);
}

inline std::from_chars_result parse_double(const char* first, const char* last, double& value) {
  const bool negative = first != last && *first == '-';
  const char* digits = negative ? first + 1 : first;
  for (const auto& [word, number] : {std::pair{"infinity", std::numeric_limits<double>::infinity()},
                                     {"inf", std::numeric_limits<double>::infinity()},
                                     {"nan", std::numeric_limits<double>::quiet_NaN()}})
    if (const char* end = end_of_word(digits, last, word); end != digits) {
      value = negative ? -number : number;
      return {end, {}};
    }
  const char* end = end_of_number(first, last);
  if (end == first) return {first, std::errc::invalid_argument};
  std::istringstream stream{std::string{first, end}};
  stream.imbue(std::locale::classic());
  double read = 0;
  // The stream takes a number below the smallest normal one for an error, and reads it.
  const bool tiny = !(stream >> read) && read != 0 && std::abs(read) < std::numeric_limits<double>::min();
  if (!stream && !tiny) return {end, std::errc::result_out_of_range};
  value = read;
  return {end, {}};
}

#endif

}  // namespace tactus
