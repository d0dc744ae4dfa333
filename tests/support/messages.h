#pragma once

#include <ostream>
#include <regex>
#include <string>

namespace tactus::test {

/// What tests pin of error messages: places, quoted names, sections, options, keys before "=" and numbers.
inline std::string pinned(std::string text) {
  static const std::regex possessive{R"((\w)'s\b)"};
  static const std::regex kept{
      R"re([\w./-]+\.(toml|wav|jsonl)(:\d+)*|'[^'\n]*'|"[^"\n]*"|`[^`\n]*`|\[\w+\]|--[\w-]+|\w+(?= =)|-?\d[\w.+/^-]*|\n)re"};
  text = std::regex_replace(text, possessive, "$1s");
  std::string found;
  for (std::sregex_iterator it{text.begin(), text.end(), kept}, end; it != end; ++it)
    found += it->str() + " ";
  return found;
}

/// Error messages, equal to others if what tests pin of them is equal: their prose may change.
struct Messages : std::string {
  Messages(std::string text) : std::string{std::move(text)} {}
  Messages(const char* text) : std::string{text} {}
  friend bool operator==(const Messages& a, const Messages& b) { return pinned(a) == pinned(b); }
  friend bool operator==(const Messages& a, const std::string& b) { return pinned(a) == pinned(b); }
  friend bool operator==(const Messages& a, const char* b) { return pinned(a) == pinned(b); }
  friend std::ostream& operator<<(std::ostream& out, const Messages& messages) {
    return out << static_cast<const std::string&>(messages);
  }
};

}  // namespace tactus::test
