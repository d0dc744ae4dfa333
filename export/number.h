#pragma once

// Thread: [control].

#include <string>
#include <string_view>
#include <vector>

namespace tactus {

/// What an exported program calculates with.
struct NumberType {
  const char* name;             ///< as --number takes it
  const char* c_type;           ///< "double"
  const char* function_suffix;  ///< of the functions of math.h
  const char* literal_suffix;
  bool exact_functions;  ///< functions of expressions give the bits of the engine; else those of math.h
  int bytes;
  int bits = 0;  ///< of an integer; 0: floating point
};

/// The entry of that name, or nullptr.
const NumberType* find_number_type(std::string_view name);
std::vector<std::string> number_type_names();

/// The shortest text that reads back as this number: "0.5", "-1e-09f", "INFINITY".
std::string c_number(double value, const NumberType& type);

/// "{0.5, 1.0}", with so many in a line.
std::string c_list(const std::vector<std::string>& values, std::size_t in_a_line);

/// C text for doubles as text for this type: its literals and functions of math.h get the suffixes.
/// Comments stay.
std::string with_numbers(std::string_view code, const NumberType& type);

/// Calls `code` with each part of a C text that is code, `comment` with each that is a comment.
template <class Code, class Comment>
void for_code_and_comments(std::string_view text, Code code, Comment comment) {
  while (!text.empty()) {
    const auto line = text.find("//"), block = text.find("/*");
    const auto begin = line < block ? line : block;
    if (begin > 0) code(text.substr(0, begin));
    if (begin == std::string_view::npos) return;
    auto end = line < block ? text.find('\n', begin) : text.find("*/", begin + 2);
    if (end != std::string_view::npos && block < line) end += 2;
    end = end == std::string_view::npos ? text.size() : end;
    comment(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
}

inline bool is_identifier_start(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
inline bool is_identifier_part(char c) { return is_identifier_start(c) || (c >= '0' && c <= '9'); }

/// Calls `with` with each identifier of C code that has no comments.
template <class With>
void for_each_identifier(std::string_view code, With with) {
  for (std::size_t at = 0; at < code.size();) {
    if (!is_identifier_part(code[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < code.size() && is_identifier_part(code[end])) ++end;
    if (is_identifier_start(code[at])) with(code.substr(at, end - at));
    at = end;
  }
}

}  // namespace tactus
