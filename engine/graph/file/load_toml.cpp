namespace tactus {
namespace {
/// An assertion of the parser that a malformed text violates.
struct ParserAssertion {};
[[noreturn]] void stop_parsing() { throw ParserAssertion{}; }
}  // namespace
}  // namespace tactus

// Malformed texts can reach assertions of the parser, which would end the program or, without assertions, be
// taken for true. Here they stop the parsing instead. This is the only file that may include the parser.
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_EXCEPTIONS 1
#define TOML_ASSERT(expression)                  \
  do {                                           \
    if (!(expression)) ::tactus::stop_parsing(); \
  } while (false)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <system_error>
#include <utility>

#include "engine/core/index.h"
#include "engine/core/parse_double.h"
#include "engine/graph/file/load.h"

namespace tactus {
namespace {

using FileName = std::shared_ptr<const std::string>;

Source place(const FileName& file, const toml::source_region& region) {
  return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

// ---- what the parser may see ----

constexpr std::size_t kMaxFileBytes = 16u << 20;
constexpr std::size_t kMaxTomlDepth = 64;
constexpr std::size_t kMaxTomlValues = 250'000;

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

/// Follows brackets and the dots of keys, from one '=', comma, bracket or line to the next, and counts
/// values.
class BracketScan {
 public:
  BracketScan(std::string_view text, const Source& file) : text_(text), file_(file) {}

  /// Errors: the first bracket or dot that lies too deep, bracket that closes one of the other kind, or value
  /// too many.
  Status run() {
    for (std::size_t i = 0; i < text_.size();) {
      const char c = text_[i];
      if ((c == '"' || c == '\'') && may_begin_string(i)) {
        i = skip_string(text_, i);
      } else if (c == '#') {
        i = std::min(text_.find('\n', i), text_.size());
      } else if (static_cast<unsigned char>(c) >= 0x80) {
        // TOML knows none there, and the parser asks of some whether they are blanks, with no answer ready.
        if (i > 0 || !text_.starts_with(kByteOrderMark)) return stray(i);
        i = kByteOrderMark.size();
      } else {
        if (!fits(c)) return stop(i, "brackets or dots more than 64 deep", "reduce the nesting");
        if (closes_another(c))
          return stop(i, fmt::format("'{}' closes a '{}'", c, c == ']' ? '{' : '['),
                      fmt::format("write '{}'", c == ']' ? '}' : ']'));
        values_ += c == '=' || c == ',' || c == '[' ? 1 : 0;
        if (values_ > kMaxTomlValues)
          return stop(i, "more than 250000 values", "store tables of numbers in a sound file");
        ++i;
      }
    }
    return {};
  }

 private:
  tl::unexpected<Error> stop(std::size_t offset, std::string what, std::string remedy) const {
    return fail(Errc::Syntax, place_of(text_, offset, file_).text(), std::move(what), std::move(remedy));
  }

  /// Where a key or a value may begin. To the parser a quote elsewhere is part of something malformed.
  bool may_begin_string(std::size_t offset) const {
    while (offset > 0 && (text_[offset - 1] == ' ' || text_[offset - 1] == '\t')) --offset;
    return offset == 0 || std::string_view{"=,[{.\n"}.find(text_[offset - 1]) != std::string_view::npos ||
           (offset == kByteOrderMark.size() && text_.starts_with(kByteOrderMark));
  }

  /// A character that may be a blank to the eye: so its number is given, too.
  tl::unexpected<Error> stray(std::size_t offset) const {
    const auto character = text_.substr(offset, character_length(text_.substr(offset, 4)));
    unsigned code = static_cast<unsigned char>(character[0]) & (0x7fu >> character.size());
    for (const char c : character.substr(1)) code = code << 6 | (static_cast<unsigned char>(c) & 0x3fu);
    return stop(offset, fmt::format("'{}' (U+{:04X}) is not allowed outside quotes", character, code),
                "put the text around it in quotes, or remove it");
  }

  bool fits(char c) {
    dots_ = c == '.' ? dots_ + 1 : std::string_view{"=,[]{}\n"}.find(c) != std::string_view::npos ? 0 : dots_;
    if (c == '[' || c == '{') open_ += c;
    return open_.size() <= kMaxTomlDepth && dots_ <= kMaxTomlDepth;
  }

  bool closes_another(char c) {
    if ((c != ']' && c != '}') || open_.empty()) return false;
    const char opened = open_.back();
    open_.pop_back();
    return (opened == '[') != (c == ']');
  }

  std::string_view text_;
  Source file_;
  std::string open_;
  std::size_t dots_ = 0;
  std::size_t values_ = 0;
};

/// What a text must satisfy before a recursive TOML parser may see it: at most 16 MB, valid UTF-8, brackets
/// and dots of keys at most 64 deep, at most 250000 values (counted by '=', commas and '['). Errors: Syntax,
/// with the place.
Status check_toml_limits(std::string_view text, const Source& file) {
  if (text.size() > kMaxFileBytes)
    return fail(Errc::Syntax, file.text(), "the file is larger than 16 MB",
                "split the file, or keep data in sound files");
  if (const auto bad = first_bad_utf8(text); bad != text.npos)
    return fail(Errc::Syntax, place_of(text, bad, file).text(), "this is not UTF-8 text",
                "save the file as UTF-8");
  return BracketScan{text, file}.run();
}

// ---- errors of the parser ----

std::string_view line_of(std::string_view text, int line) {
  for (; line > 1 && text.find('\n') != text.npos; --line) text.remove_prefix(text.find('\n') + 1);
  return text.substr(0, text.find_first_of("\r\n"));
}

struct Unquoted {
  std::string_view value;
  int column;
};

/// The most common error: `time = 12 ms` or `in = microphone` where quotes belong. Nothing if it is another
/// one.
std::optional<Unquoted> find_unquoted(std::string_view line, int error_column) {
  const auto start = line.substr(0, index(std::max(error_column - 1, 0))).find_last_of("=,[{");
  if (start == line.npos || line.substr(line.find_first_not_of(" \t")).starts_with('[')) return std::nullopt;
  const auto first = line.find_first_not_of(" \t", start + 1);
  if (first == line.npos) return std::nullopt;
  auto value = line.substr(first, line.find_first_of(",]}#", first) - first);
  value = value.substr(0, value.find_last_not_of(" \t") + 1);
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  if (value.find_first_of("\"'=") != value.npos || std::none_of(value.begin(), value.end(), letter))
    return std::nullopt;
  return Unquoted{value, static_cast<int>(first) + 1};
}

tl::unexpected<Error> explain(const toml::parse_error& error, std::string_view text, const FileName& file) {
  Source at = place(file, error.source());
  std::string what{error.description()};
  if (what.find("redefine") != what.npos)
    return fail(Errc::Duplicate, at.text(), what.substr(what.find("cannot")),
                what.find("existing table") != what.npos
                    ? "put all its entries under one heading, or rename one of the two"
                    : "rename or remove one of the two");
  if (const auto unquoted = find_unquoted(line_of(text, at.line), at.column)) {
    at.column = unquoted->column;
    const std::string value{unquoted->value};
    return fail(Errc::Syntax, at.text(), "'" + value + "' needs quotes", "write \"" + value + "\"");
  }
  // "Error while parsing array: expected …" becomes "in this array: expected …".
  constexpr std::string_view kBoilerplate = "Error while parsing ";
  if (what.starts_with(kBoilerplate)) what = "in this " + what.substr(kBoilerplate.size());
  return fail(Errc::Syntax, at.text(), what, "fix this to see further errors");
}

// ---- the parser's tree as plain data ----

Result<Value> convert(const toml::node& node, const FileName& file);

Result<Value::Table> convert_table(const toml::table& table, const FileName& file) {
  Value::Table fields;
  for (const auto& [key, node] : table) {
    auto value = convert(node, file);
    if (!value) return tl::unexpected(value.error());
    fields.push_back({std::string{key.str()}, place(file, key.source()), std::move(*value)});
  }
  // The parser sorts by name; people and messages go by the order in the file.
  std::ranges::stable_sort(fields, {}, [](const Field& f) { return std::pair{f.at.line, f.at.column}; });
  return fields;
}

Result<Value::List> convert_list(const toml::array& array, const FileName& file) {
  Value::List list;
  for (const auto& node : array) {
    auto value = convert(node, file);
    if (!value) return tl::unexpected(value.error());
    list.push_back(std::move(*value));
  }
  return list;
}

Result<Value> convert(const toml::node& node, const FileName& file) {
  const Source at = place(file, node.source());
  const auto with_place = [&](auto data) { return Value{std::move(data), at}; };
  if (const auto* text = node.as_string()) return Value{text->get(), at};
  if (const auto* flag = node.as_boolean()) return Value{flag->get(), at};
  if (const auto* whole = node.as_integer()) return Value{static_cast<double>(whole->get()), at};
  if (const auto* table = node.as_table()) return convert_table(*table, file).map(with_place);
  if (const auto* array = node.as_array()) return convert_list(*array, file).map(with_place);
  if (const auto* real = node.as_floating_point()) {
    if (std::isfinite(real->get())) return Value{without_denormals(real->get()), at};
    return fail(Errc::OutOfRange, at.text(), "inf and nan are not allowed", "give a finite number");
  }
  return fail(Errc::WrongType, at.text(), "dates and times are not allowed here",
              "put it in quotes if it is a string");
}

}  // namespace

Result<std::string> read_graph_text(const std::filesystem::path& file) {
  const auto name = file.generic_string();
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    return fail(Errc::BadFile, name, "this is a folder", "give a file in it");
  if (!std::filesystem::exists(file, error))
    return fail(Errc::BadFile, name, "there is no such file", "check the path");
  if (!std::filesystem::is_regular_file(file, error))
    return fail(Errc::BadFile, name, "this is not a regular file", "give a regular file");
  std::ifstream stream(file, std::ios::binary);
  // One byte more than allowed shows that a file is too large, even one without an end.
  std::string text(kMaxFileBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream.eof() && stream.fail())
    return fail(Errc::BadFile, name, "cannot be read", "check its permissions");
  text.resize(index(stream.gcount()));
  return text;
}

Result<Value::Table> parse_toml(std::string_view text, const std::string& file_name) {
  const auto file = std::make_shared<const std::string>(file_name);
  if (const auto fits = check_toml_limits(text, {file, 0, 0}); !fits) return tl::unexpected(fits.error());
  try {
    return convert_table(toml::parse(text, file_name), file);
  } catch (const toml::parse_error& error) {
    return explain(error, text, file);
  } catch (const ParserAssertion&) {
    return fail(Errc::Syntax, file_name, "this is not valid TOML; the parser cannot locate the error",
                "look for missing brackets, quotes and commas");
  }
}

Result<Value::Table> load_toml(const std::filesystem::path& file) {
  const auto text = read_graph_text(file);
  if (!text) return tl::unexpected(text.error());
  return parse_toml(*text, file.generic_string());
}

}  // namespace tactus
