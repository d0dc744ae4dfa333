#include "engine/graph/file/unit_prefix.h"

#include <algorithm>
#include <charconv>

#include "engine/core/dimension.h"

namespace tactus {
namespace {

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

}  // namespace tactus
