#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/temporary_folder.h"

// Files that were not written by a person.

using namespace tactus;
using test::TemporaryFolder;

namespace {

constexpr auto kFormat = "format = 1\n";

std::string file_errors(const TemporaryFolder& folder, const std::filesystem::path& file) {
  const auto schedule = compile(load_graph_leniently(file), standard_nodes(), {});
  return folder.strip(test::summary(schedule));
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

/// "n0 = …", one line a node; '#' stands for the number.
std::string lines(int count, const std::string& line) {
  std::string text;
  for (int i = 0; i < count; ++i)
    for (const char c : line) text += c == '#' ? std::to_string(i) : std::string{c};
  return text;
}

}  // namespace

TEST_CASE("hostile files: no file, a folder, nothing, bytes, a gigabyte", "[graph]") {
  const TemporaryFolder folder;
  CHECK(file_errors(folder, folder.path() / "none.toml") == "none.toml BadFile");
  std::filesystem::create_directory(folder.path() / "folder.toml");
  CHECK(file_errors(folder, folder.path() / "folder.toml") == "folder.toml BadFile");
  CHECK(file_errors(folder, folder.write("empty.toml", "")) == "empty.toml:1:1 Missing 'format' format 1");
  CHECK(file_errors(folder, folder.write("binary.toml", std::string("\x7f"
                                                                    "ELF\x02\x01\x01\x00\x00\xff\xfe",
                                                                    11))) == "binary.toml:1:10 Syntax");
  const auto zeros = file_errors(folder, folder.write("zeros.toml", std::string(64, '\0')));
  CHECK(zeros.starts_with("zeros.toml:1:1 Syntax"));
  CHECK(zeros.find('\0') == std::string::npos);
  const auto huge = folder.write("huge.toml", kFormat);
  std::filesystem::resize_file(huge, 1u << 30);
  CHECK(file_errors(folder, huge) == "huge.toml Syntax 16");
}

TEST_CASE("hostile files: nesting 100000 deep is refused before the parser recurses", "[graph]") {
  for (const std::string open : {"[", "{ a = ", "a.", "[[", "[{ a = "}) {
    INFO(open);
    const auto text = (open == "a." ? "" : "x = ") + repeated(open, 100000);
    CHECK(test::errors_of(text).ends_with(" Syntax 64"));
  }
  CHECK(test::errors_of("[" + repeated("a.", 100000) + "b]\n").ends_with(" Syntax 64"));
}

TEST_CASE("hostile files: 10000 nodes or masses load, more values than a parser stands do not", "[graph]") {
  CHECK(
      test::errors_of("format = 1\n[inputs]\nx = {}\n[nodes]\nn0 = { type = \"low_pass\", in = \"x\", cutoff "
                      "= \"1 kHz\" }\n" +
                      lines(10000, "m# = { type = \"clip\", in = \"0.5 * n0\" }\n") +
                      "[outputs]\ny = { from = \"m9999\" }\n") == "");
  CHECK(test::errors_of("format = 1\n[networks.star]\nsolver = \"explicit\"\n" +
                        lines(10000, "m# = { type = \"mass\", mass = \"1 g\" }\n") +
                        lines(9999,
                              "s# = { type = \"spring\", between = [\"m#\", \"m9999\"], stiffness = "
                              "\"1 N/m\" }\n") +
                        "[outputs]\ny = { from = \"star.m9999.position\", unit = \"m\" }\n") == "");
  CHECK(test::errors_of("format = 1\n[nodes]\n" + lines(260000, "n# = 1\n")) ==
        "test.toml:250001:9 Syntax 250000");
  // 10^7 of them are more than 16 MB.
  CHECK(test::errors_of(repeated("a=\n", 10'000'000)) == "test.toml Syntax 16");
}

TEST_CASE("hostile files: a long chain of names, written backwards, and as many wrong ones",
          "[graph][slow]") {
  std::string chain = "format = 1\n[nodes]\n";
  for (int i = 20000; i > 0; --i)
    chain += "n" + std::to_string(i) + " = \"n" + std::to_string(i - 1) + "\"\n";
  CHECK(test::errors_of(chain + "n0 = \"1 N\"\n[outputs]\ny = { from = \"n20000\", unit = \"N\" }\n") == "");
  const auto many = test::errors_of("format = 1\n[nodes]\n" + lines(20000, "n# = \"wrong#\"\n"));
  CHECK(std::count(many.begin(), many.end(), '\n') == 19999);
}

TEST_CASE("hostile files: parts of parts that double are refused", "[graph]") {
  const TemporaryFolder folder;
  for (int i = 0; i < 30; ++i) {
    const auto next = "\"p" + std::to_string(i + 1) + ".toml\"";
    folder.write("p" + std::to_string(i) + ".toml",
                 kFormat + ("[nodes]\na = { use = " + next + " }\nb = { use = " + next + " }\n"));
  }
  folder.write("p30.toml", std::string{kFormat} + "[nodes]\na = \"1\"\n");
  const auto doubled = file_errors(folder, folder.path() / "p0.toml");
  CHECK(doubled.ends_with(" OutOfRange 250000"));
  CHECK(std::count(doubled.begin(), doubled.end(), '\n') == 0);
}

TEST_CASE("hostile files: neither lanes nor delays can ask for more than there is", "[graph]") {
  CHECK(test::errors_of("format = 1\n[inputs]\nx = { lanes = 1024 }\n[nodes]\n" +
                        lines(3, "n# = \"x" + repeated(" + x", 99) + "\"\n")) ==
        "test.toml OutOfRange 250000");
  const auto delays = test::errors_of(
      "format = 1\n[inputs]\nx = {}\n[nodes]\na = { type = \"delay\", in = \"x\", time = \"10 s\", voices = "
      "1024 }\nb = { type = \"mix\", in = \"a\" }\n[outputs]\ny = { from = \"b\" }\n");
  CHECK(delays == "test.toml:5:1 OutOfRange 'a' 512");
}

#if defined(TACTUS_HAS_SNDFILE)  // the node `sample`
TEST_CASE("hostile files: a file of a node does not lead out of its folder either", "[graph]") {
  const TemporaryFolder folder;
  folder.write("secret.wav", "RIFF");
  const auto with = [&](const std::string& name) {
    return file_errors(folder, folder.write("drum/a.toml",
                                            "format = 1\n[nodes]\na = { type = \"sample\", trigger = 1, "
                                            "file = \"" +
                                                name + "\" }\n"));
  };
  CHECK(with("../secret.wav") == "drum/a.toml:3:44 OutOfRange '../secret.wav' 'drum'");
  CHECK(with("/etc/passwd") == "drum/a.toml:3:44 OutOfRange '/etc/passwd'");
  std::filesystem::create_symlink(folder.path() / "secret.wav", folder.path() / "drum/link.wav");
  CHECK(with("link.wav") == "drum/a.toml:3:44 OutOfRange 'link.wav' 'drum'");
  CHECK(with("thunder_and_lightning.wav") == "drum/a.toml:3:44 BadFile 'drum/thunder_and_lightning.wav'");
  CHECK(with(std::string(5000, 'a')).starts_with("drum/a.toml:3:44 BadFile '"));
}
#endif

TEST_CASE("hostile files: no character of a file reaches the terminal as a command", "[graph]") {
  CHECK(test::errors_of("format = 1\n[nodes]\na = { type = \"\\u001b[31mclip\\nall is well\" }\n") ==
        "test.toml:3:14 UnknownName '?[31mclip?all is well' `tactus nodes`");
  CHECK(test::errors_of("format = 1\n[nodes]\na = { type = \"\xC2\x9B"
                        "31mclip\" }\n") == "test.toml:3:14 UnknownName '?31mclip' `tactus nodes`");
}
