#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "engine/graph/file/load.h"

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

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

struct Violation {
  std::size_t offset;
  std::string what, remedy;
};

/// Follows brackets and the dots of keys, from one '=', comma, bracket or line to the next, and counts
/// values.
class BracketScan {
 public:
  explicit BracketScan(std::string_view text) : text_(text) {}

  /// The first bracket or dot that lies too deep, bracket that closes one of the other kind, or value too
  /// many.
  std::optional<Violation> first_violation() {
    for (std::size_t i = 0; i < text_.size();) {
      const char c = text_[i];
      if (c == '"' || c == '\'') {
        i = skip_string(text_, i);
      } else if (c == '#') {
        i = std::min(text_.find('\n', i), text_.size());
      } else if (static_cast<unsigned char>(c) >= 0x80) {
        // TOML knows none there, and the parser asks of some whether they are blanks, with no answer ready.
        if (i > 0 || !text_.starts_with(kByteOrderMark)) return stray(i);
        i = kByteOrderMark.size();
      } else {
        if (!fits(c)) return Violation{i, "brackets or dots more than 64 deep", "reduce the nesting"};
        if (auto violation = close(c, i)) return violation;
        values_ += c == '=' || c == ',' || c == '[' ? 1 : 0;
        if (values_ > kMaxTomlValues)
          return Violation{i, "more than 250000 values", "store tables of numbers in a sound file"};
        ++i;
      }
    }
    return std::nullopt;
  }

 private:
  /// A character that may be a blank to the eye: so its number is given, too.
  Violation stray(std::size_t offset) const {
    const auto character = text_.substr(offset, character_length(text_.substr(offset, 4)));
    unsigned code = static_cast<unsigned char>(character[0]) & (0x7fu >> character.size());
    for (const char c : character.substr(1)) code = code << 6 | (static_cast<unsigned char>(c) & 0x3fu);
    return {offset, fmt::format("'{}' (U+{:04X}) is not allowed outside quotes", character, code),
            "put the text around it in quotes, or remove it"};
  }

  bool fits(char c) {
    dots_ = c == '.' ? dots_ + 1 : std::string_view{"=,[]{}\n"}.find(c) != std::string_view::npos ? 0 : dots_;
    if (c == '[' || c == '{') open_ += c;
    return open_.size() <= kMaxTomlDepth && dots_ <= kMaxTomlDepth;
  }

  std::optional<Violation> close(char c, std::size_t offset) {
    if ((c != ']' && c != '}') || open_.empty()) return std::nullopt;
    const char opened = open_.back();
    open_.pop_back();
    if ((opened == '[') == (c == ']')) return std::nullopt;
    return Violation{offset, std::string{"'"} + c + "' closes a '" + opened + "'",
                     std::string{"write '"} + (opened == '[' ? ']' : '}') + "'"};
  }

  std::string_view text_;
  std::string open_;
  std::size_t dots_ = 0;
  std::size_t values_ = 0;
};

}  // namespace

Status check_toml_limits(std::string_view text, const Source& file) {
  if (text.size() > kMaxFileBytes)
    return fail(Errc::Syntax, file.text(), "the file is larger than 16 MB",
                "split the file, or keep data in sound files");
  if (const auto bad = first_bad_utf8(text); bad != text.npos)
    return fail(Errc::Syntax, place_of(text, bad, file).text(), "this is not UTF-8 text",
                "save the file as UTF-8");
  if (auto violation = BracketScan{text}.first_violation())
    return fail(Errc::Syntax, place_of(text, violation->offset, file).text(), violation->what,
                violation->remedy);
  return {};
}

}  // namespace tactus
