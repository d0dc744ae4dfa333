#include "engine/graph/toml_limits.h"

#include <algorithm>
#include <string>

namespace tactus {
namespace {

bool starts(char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }  // a UTF-8 character

/// Bytes of the UTF-8 character at the beginning of `text`; 0 if it is none (RFC 3629: no overlong forms, no
/// surrogates, nothing above U+10FFFF).
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(0), second = byte(1);
  if (first < 0x80) return 1;
  const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0u) != 0x80u) return 0;
  if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F)) return 0;
  if ((first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F)) return 0;
  return length;
}

Source place_of(std::string_view text, std::size_t offset, Source file) {
  const auto before = text.substr(0, offset);
  const auto line_start = before.rfind('\n') + 1;  // npos + 1 = 0: the first line
  const auto in_line = before.substr(line_start);
  file.line = static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1;
  file.column = static_cast<int>(std::count_if(in_line.begin(), in_line.end(), starts)) + 1;
  return file;
}

std::size_t first_bad_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto length = character_length(text.substr(i, 4));
    if (length == 0) return i;
    i += length;
  }
  return text.npos;
}

/// Behind the string whose first quote is at `i`. An unclosed string ends with its line, where the parser
/// stops.
std::size_t skip_string(std::string_view text, std::size_t i) {
  const char quote = text[i];
  const std::string triple(3, quote);
  const bool multi_line = text.substr(i).starts_with(triple);
  i += multi_line ? 3 : 1;
  while (i < text.size()) {
    if (quote == '"' && text[i] == '\\') {
      i += 2;
    } else if (multi_line ? text.substr(i).starts_with(triple) : text[i] == quote) {
      i += multi_line ? 3 : 1;
      // Up to two more quotes may belong to the text before the closing three.
      while (multi_line && i < text.size() && text[i] == quote) ++i;
      return i;
    } else if (!multi_line && text[i] == '\n') {
      return i;
    } else {
      ++i;
    }
  }
  return text.size();
}

/// The first bracket or dot that lies too deep. Dots count since the last '=', comma, bracket or line.
std::size_t first_too_deep(std::string_view text) {
  int brackets = 0, dots = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = skip_string(text, i);
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    if (c == '[' || c == '{') ++brackets;
    if ((c == ']' || c == '}') && brackets > 0) --brackets;
    dots = c == '.' ? dots + 1 : std::string_view{"=,[]{}\n"}.find(c) != std::string_view::npos ? 0 : dots;
    if (brackets > kMaxTomlDepth || dots > kMaxTomlDepth) return i;
    ++i;
  }
  return text.npos;
}

}  // namespace

Status check_toml_limits(std::string_view text, const Source& file) {
  if (text.size() > kMaxFileBytes)
    return fail(Errc::Syntax, file.text(), "the file is larger than 16 MB",
                "graph files are text of a few pages");
  if (const auto bad = first_bad_utf8(text); bad != text.npos)
    return fail(Errc::Syntax, place_of(text, bad, file).text(), "this is not UTF-8 text",
                "save the file as UTF-8");
  if (const auto deep = first_too_deep(text); deep != text.npos)
    return fail(Errc::Syntax, place_of(text, deep, file).text(), "brackets or dots more than 64 deep",
                "close some of them before");
  return {};
}

}  // namespace tactus
