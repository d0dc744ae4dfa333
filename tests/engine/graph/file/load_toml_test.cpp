#include <catch2/catch.hpp>

#include "engine/graph/file/load.h"
#include "tests/support/error_summary.h"

using namespace tactus;

namespace {

std::string refused(std::string_view text) {
  const auto table = parse_toml(text, "a.toml");
  return table ? "read" : test::summary(table);
}

}  // namespace

TEST_CASE("toml: values keep their kind, their order and their place", "[graph]") {
  const auto table = parse_toml(R"(z = 1
a = { y = "é", b = true }   # out of alphabetical order
[n.two]
list = [0.5, "1 ms"]
[n.one]
)",
                                "a.toml");
  REQUIRE(table);
  REQUIRE(table->size() == 3);
  CHECK((*table)[0].key == "z");
  CHECK(*(*table)[0].value.number() == 1.0);
  const auto& a = *(*table)[1].value.table();
  CHECK(a[0].key == "y");
  CHECK(*a[0].value.text() == "é");
  CHECK(a[0].value.at.text() == "a.toml:2:11");
  CHECK(a[1].at.text() == "a.toml:2:16");  // columns are characters, and é is one
  CHECK(*a[1].value.flag());
  const auto& n = *(*table)[2].value.table();
  CHECK(n[0].key == "two");
  CHECK(n[0].at.text() == "a.toml:3:4");
  CHECK(n[1].key == "one");
  const auto& list = *find(*n[0].value.table(), "list")->list();
  CHECK(*list[0].number() == 0.5);
  CHECK(list[1].at.text() == "a.toml:4:14");
}

TEST_CASE("toml: a byte order mark and Windows line ends are fine", "[graph]") {
  const auto table = parse_toml(
      "\xEF\xBB\xBF"
      "a = 1\r\nb = 2\r\n",
      "a.toml");
  REQUIRE(table);
  CHECK((*table)[0].at.text() == "a.toml:1:1");
  CHECK((*table)[1].at.text() == "a.toml:2:1");
}

TEST_CASE("toml: a syntax error is said in words, with its place", "[graph]") {
  const auto [text, message] = GENERATE(table<std::string, std::string>({
      {"x = { time = 12 ms }", R"(a.toml:1:14 Syntax '12 ms' "12 ms")"},
      {"in = microphone # why", R"(a.toml:1:6 Syntax 'microphone' "microphone")"},
      {"range = [0, 60 dB]", R"(a.toml:1:13 Syntax '60 dB' "60 dB")"},
      {"a = 1\na = 2", "a.toml:2:5 Duplicate 'a'"},
      {"[n]\nx = 1\n[n]", "a.toml:3:1 Duplicate 'n'"},
      {"[nodes\nx = 1", "a.toml:1:7 Syntax ']' '\\n'"},
      {"a = [1,", "a.toml:1:8 Syntax"},
      {"a = \"x", "a.toml:1:7 Syntax"},
      {"a = 1\nb = 'caf\xe9'", "a.toml:2:9 Syntax"},
      {"a = \"\xed\xa0\x80\"", "a.toml:1:6 Syntax"},
      {"a = [1, {x = 2]", "a.toml:1:15 Syntax ']' '{' '}'"},
      {"a = [ }", "a.toml:1:7 Syntax '}' '[' ']'"},
      {"a = ]", "a.toml:1:5 Syntax ']'"},
      {"a = inf", "a.toml:1:5 OutOfRange"},
      {"a = 2007-06-06", "a.toml:1:5 WrongType"},
  }));
  CHECK(refused(text) == message);
}

TEST_CASE("toml: texts that run into the parser's own assertions are errors like any other", "[graph]") {
  // The words differ with the parser's version; that the program lives on does not.
  const auto text = GENERATE("[[[1]]]", "[[[]]", "[[=", "a = [\r}", "a = {\x7f}", "a = +_", "'");
  const auto table = parse_toml(text, "a.toml");
  REQUIRE_FALSE(table);
  CHECK(table.error().code == Errc::Syntax);
  CHECK(table.error().where.starts_with("a.toml"));
}

TEST_CASE("toml: a quote within something malformed begins no text", "[graph]") {
  // The parser asks of each character behind it whether it is a blank, with no answer for some.
  CHECK(refused("a = 4\"0.4 \u0385\"") == "a.toml:1:11 Syntax '\u0385' U+0385");
  CHECK(refused("a = [ \"\u0385\", '\u0385' ]\n'\u0385' = 1\n\"b\".\"\u0385\" = 1\n[ 'c' ]\n\t\"\u0385\" = "
                "{\"\u0385\" = 1}") == "read");
}

TEST_CASE("toml: depth and size are bounded before the parser recurses", "[graph]") {
  const std::string lists = "a = " + std::string(64, '[') + std::string(64, ']');
  CHECK(refused(lists) == "read");
  const auto deep = GENERATE(std::string(1 << 20, '['), std::string(1 << 20, '{'), [] {
    std::string keys;
    for (int i = 0; i < (1 << 20); ++i) keys += "a.";
    return keys;
  }());
  const bool dots = deep[0] == 'a';
  CHECK(refused("a = \"é[\" # ]\n" + deep) ==
        std::string{"a.toml:2:"} + (dots ? "130" : "65") + " Syntax 64");
  CHECK(refused(std::string((16u << 20) + 1, ' ')) == "a.toml Syntax 16");
}

TEST_CASE("toml: brackets in strings and comments do not count", "[graph]") {
  const std::string brackets(100, '[');
  const std::string quotes = "\"\"\"";
  CHECK(refused("a = \"\\\"" + brackets + "\"") == "read");
  CHECK(refused("a = '\\" + brackets + "'") == "read");
  CHECK(refused("a = " + quotes + "\n\"\"" + brackets + "\n\"" + quotes + "\nb = 1") == "read");
  CHECK(refused("a = '''" + brackets + "''''' # " + brackets) == "read");
}

TEST_CASE("toml: a file that cannot be opened says why", "[graph]") {
  CHECK(test::summary(load_toml("no/such.toml")) == "no/such.toml BadFile");
  const std::filesystem::path folder = TACTUS_SOURCE_DIR;
  CHECK(test::summary(load_toml(folder)) == folder.string() + " BadFile");
}
