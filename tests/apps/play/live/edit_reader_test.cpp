#include "apps/play/live/edit_reader.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <new>

#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using app::Edit;
using app::EditReader;
using app::WatchedFiles;
using test::wait_until;

TEST_CASE("watched files: a change is reported once, so are a file that goes and one that comes", "[live]") {
  const test::TemporaryFolder folder;
  folder.write("a.toml", "one");
  folder.write("b.toml", "two");
  WatchedFiles files;
  files.watch({folder.path() / "a.toml", folder.path() / "b.toml"});
  CHECK_FALSE(files.changed());
  folder.write("b.toml", "longer");
  CHECK(files.changed());
  CHECK_FALSE(files.changed());
  std::filesystem::remove(folder.path() / "a.toml");
  CHECK(files.changed());
  CHECK_FALSE(files.changed());
  folder.write("a.toml", "one");
  CHECK(files.changed());
}

TEST_CASE("watched files: looking at other files forgets nothing about those that stay", "[live]") {
  const test::TemporaryFolder folder;
  folder.write("a.toml", "one");
  WatchedFiles files;
  files.watch({folder.path() / "a.toml"});
  folder.write("a.toml", "three");
  files.watch({folder.path() / "a.toml", folder.path() / "b.toml"});
  CHECK(files.changed());
}

TEST_CASE("edit reader: a file system that does not answer holds up no one, and its edit comes later",
          "[live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("a.toml", "one");
  std::atomic<bool> stalls{false}, stalled{false};
  WatchedFiles files{[&](const std::filesystem::path& path) {
    stalled = stalls.load();
    (void)wait_until([&] { return !stalls; });
    return WatchedFiles::read_stamp(path);
  }};
  files.watch({file});
  EditReader edits{std::move(files), [&] { return Edit{{file}, {}, "read", {}}; }};
  stalls = true;
  REQUIRE(wait_until([&] { return stalled.load(); }));
  folder.write("a.toml", "longer");
  CHECK_FALSE(edits.take());
  CHECK(stalls);  // it did not wait for that
  stalls = false;
  std::optional<Edit> edit;
  REQUIRE(wait_until([&] { return (edit = edits.take()).has_value(); }));
  CHECK(edit->warning == "read");
  CHECK_FALSE(edits.take());
}

TEST_CASE("edit reader: too little memory for a look does not end it", "[live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("a.toml", "one");
  std::atomic<int> looks{0};
  WatchedFiles files{[&](const std::filesystem::path& path) {
    const int look = ++looks;
    if (look == 2 || look == 3) throw std::bad_alloc{};
    return WatchedFiles::read_stamp(path);
  }};
  files.watch({file});
  EditReader edits{std::move(files), [&] { return Edit{{file}, {}, "read", {}}; }};
  REQUIRE(wait_until([&] { return looks > 3; }));
  folder.write("a.toml", "longer");
  CHECK(wait_until([&] { return edits.take().has_value(); }));
}

TEST_CASE("edit reader: an edit that waits to be taken is not replaced, and what follows it is read then",
          "[live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("a.toml", "one");
  std::atomic<int> looks{0}, reads{0};
  WatchedFiles files{[&](const std::filesystem::path& path) {
    ++looks;
    return WatchedFiles::read_stamp(path);
  }};
  files.watch({file});
  EditReader edits{std::move(files), [&] { return Edit{{file}, {}, std::to_string(++reads), {}}; }};
  folder.write("a.toml", "longer");
  REQUIRE(wait_until([&] { return reads == 1; }));
  folder.write("a.toml", "longer still");
  const int before = looks;
  REQUIRE(wait_until([&] { return looks > before + 3; }));
  CHECK(reads == 1);
  CHECK(edits.take()->warning == "1");
  REQUIRE(wait_until([&] { return reads == 2; }));
}
