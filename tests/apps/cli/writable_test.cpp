#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "apps/cli/commands.h"
#include "tests/support/error_summary.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::app;

TEST_CASE("writable: whether a file can be written is found without writing it", "[apps]") {
  const test::TemporaryFolder folder;
  const auto missing = folder.path() / "none.svg", there = folder.path() / "there.svg";
  std::ofstream{there} << "kept";
  CHECK(can_write_file(missing));
  CHECK_FALSE(std::filesystem::exists(missing));
  CHECK(can_write_file(there));
  std::ifstream stream{there};
  CHECK(std::string{std::istreambuf_iterator<char>{stream}, {}} == "kept");
  CHECK_FALSE(can_write_file(folder.path()));
  const auto lost = folder.path() / "no" / "such" / "x.svg";
  const auto status = can_write_file(lost);
  REQUIRE_FALSE(status);
  CHECK(test::summary(status) == lost.string() + " BadFile");
}

TEST_CASE("writable: a folder may still be missing, but not lie in a file", "[apps]") {
  const test::TemporaryFolder folder;
  CHECK(can_write_into(folder.path()));
  CHECK(can_write_into(folder.path() / "a" / "b"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "a"));
  CHECK(std::filesystem::is_empty(folder.path()));
  std::ofstream{folder.path() / "file"} << "x";
  CHECK_FALSE(can_write_into(folder.path() / "file"));
  CHECK_FALSE(can_write_into(folder.path() / "file" / "in"));
}

TEST_CASE("writable: an option tells it when the command line is read", "[apps]") {
  const test::TemporaryFolder folder;
  const auto said = [&](const std::string& path) {
    CLI::App app;
    std::string file;
    app.add_option("--svg", file)->check(writable_file());
    try {
      app.parse("--svg " + path);
    } catch (const CLI::ParseError& error) {
      return std::string{error.what()};
    }
    return std::string{};
  };
  CHECK(said((folder.path() / "x.svg").string()).empty());
  CHECK(said((folder.path() / "no" / "x.svg").string()).starts_with("--svg: " + folder.path().string()));
}
