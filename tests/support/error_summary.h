#pragma once

#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "engine/core/error.h"

namespace tactus::test {

/// What tests compare of a text for people: file places, quoted names, sections, options, keys before "=",
/// paths of nodes and numbers, in their order. The prose between them may change. Windows: with the drive.
inline std::string names_in(std::string text) {
  static const std::regex possessive{R"((\w)'s\b)"};
  static const std::regex kept{
      R"re(((?:[A-Z]:)?[\w./-]+\.(toml|wav|jsonl)(:\d+)*|'[^'\n]*'|"[^"\n]*"|`[^`\n]*`|\[\w+\]|--[\w-]+|[\w.]+( -> [\w.]+)+|\w+(?= =)|U\+\w+|-?\d[\w.+/^-]*)|[A-Za-z]+-\d+)re"};
  text = std::regex_replace(text, possessive, "$1s");
  std::string found;
  for (std::sregex_iterator it{text.begin(), text.end(), kept}, end; it != end; ++it)
    if (it->str(1) != "") found += (found.empty() ? "" : " ") + it->str();  // no number: UTF-8
  return found;
}

inline const char* code_name(Errc code) {
  static constexpr const char* kNames[] = {"BadArgument", "BadFile",      "Syntax",     "UnknownName",
                                           "WrongType",   "UnitMismatch", "OutOfRange", "Duplicate",
                                           "Missing",     "Cycle",        "Device"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Errc::Device) + 1);
  return kNames[static_cast<std::size_t>(code)];
}

/// What tests compare of an error: place, code and names, as in "wall.toml:12:8 Cycle coil -> coil 'delay'".
inline std::string summary(const Error& error) {
  const auto names = names_in(tactus::to_string(error.at("")));
  return error.where + (error.where.empty() ? "" : " ") + code_name(error.code) + (names.empty() ? "" : " ") +
         names;
}

/// One error a line.
inline std::string summary(const std::vector<Error>& errors) {
  std::string lines;
  for (const auto& error : errors) lines += (lines.empty() ? "" : "\n") + summary(error);
  return lines;
}

/// Of what went wrong, or "".
template <class T, class E>
std::string summary(const tl::expected<T, E>& result) {
  return result ? "" : summary(result.error());
}

}  // namespace tactus::test
