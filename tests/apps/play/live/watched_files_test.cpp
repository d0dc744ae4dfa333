#include <catch2/catch.hpp>

#include "apps/play/live/session.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using app::WatchedFiles;

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
