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

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <system_error>
#include <tuple>

#include "engine/core/index.h"
#include "engine/graph/file/load.h"

namespace tactus {
namespace {

using FileName = std::shared_ptr<const std::string>;

Source place(const FileName& file, const toml::source_region& region) {
  return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
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

bool comes_before(const Field& a, const Field& b) {
  return std::tie(a.at.line, a.at.column) < std::tie(b.at.line, b.at.column);
}

Result<Value> convert(const toml::node& node, const FileName& file);

Result<Value::Table> convert_table(const toml::table& table, const FileName& file) {
  Value::Table fields;
  for (const auto& [key, node] : table) {
    auto value = convert(node, file);
    if (!value) return tl::unexpected(value.error());
    fields.push_back({std::string{key.str()}, place(file, key.source()), std::move(*value)});
  }
  // The parser sorts by name; people and messages go by the order in the file.
  std::stable_sort(fields.begin(), fields.end(), comes_before);
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
    if (std::isfinite(real->get())) return Value{real->get(), at};
    return fail(Errc::OutOfRange, at.text(), "inf and nan are not allowed", "give a finite number");
  }
  return fail(Errc::WrongType, at.text(), "dates and times are not allowed here",
              "put it in quotes if it is a string");
}

Result<Value::Table> parse(std::string_view text, const FileName& file) {
  if (const auto fits = check_toml_limits(text, {file, 0, 0}); !fits) return tl::unexpected(fits.error());
  try {
    return convert_table(toml::parse(text, std::string_view{*file}), file);
  } catch (const toml::parse_error& error) {
    return explain(error, text, file);
  } catch (const ParserAssertion&) {
    return fail(Errc::Syntax, *file, "this is not valid TOML; the parser cannot locate the error",
                "look for missing brackets, quotes and commas");
  }
}

}  // namespace

Result<std::string> read_graph_text(const std::filesystem::path& file) {
  const auto name = file.string();
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
  return parse(text, std::make_shared<const std::string>(file_name));
}

Result<Value::Table> load_toml(const std::filesystem::path& file) {
  const auto text = read_graph_text(file);
  if (!text) return tl::unexpected(text.error());
  return parse_toml(*text, file.string());
}

}  // namespace tactus
