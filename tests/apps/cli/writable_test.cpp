#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/cli/console.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::app;

namespace {

/// The error about an option; empty: none.
std::string error_of(const CLI::Validator& validator, const std::filesystem::path& path) {
  auto text = path.string();
  return validator(text);
}
bool can_write_file(const std::filesystem::path& file) { return error_of(writable_file(), file).empty(); }
bool can_write_into(const std::filesystem::path& folder) {
  return error_of(writable_folder(), folder).empty();
}

}  // namespace

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
  CHECK(error_of(writable_file(), lost).starts_with(lost.string() + ": "));
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
