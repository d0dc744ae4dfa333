#include "engine/core/files.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/temporary_folder.h"

#if defined(__linux__)
#include <sys/resource.h>

#include <csignal>
#endif

using namespace tactus;

namespace {

std::string text_in(const std::filesystem::path& file) {
  std::ifstream stream{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{stream}, {}};
}

}  // namespace

TEST_CASE("files: a replaced file stays under its name with a tilde", "[core]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "rig.toml";
  REQUIRE(replace_file_with_backup(file, "first"));
  CHECK_FALSE(std::filesystem::exists(file.string() + "~"));
  REQUIRE(replace_file_with_backup(file, "second"));
  REQUIRE(replace_file_with_backup(file, "third"));
  CHECK(text_in(file) == "third");
  CHECK(text_in(file.string() + "~") == "second");
}

#if defined(__linux__)
TEST_CASE("files: where there is no room neither the file nor its former text is lost", "[core]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "rig.toml";
  REQUIRE(replace_file_with_backup(file, "first"));
  REQUIRE(replace_file_with_backup(file, "second"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto signal = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &none);
  const auto status = replace_file_with_backup(file, "third");
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, signal);
  CHECK_FALSE(status);
  CHECK(text_in(file) == "second");
  CHECK(text_in(file.string() + "~") == "first");
  CHECK(std::distance(std::filesystem::directory_iterator{folder.path()}, {}) == 2);
}
#endif
