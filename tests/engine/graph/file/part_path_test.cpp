
#include <catch2/catch.hpp>

#include "engine/graph/file/load.h"
#include "tests/support/error_summary.h"
#include "tests/support/parse_graph.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using tactus::test::parse_graph;
using test::TemporaryFolder;

namespace {

constexpr auto kEmpty = "format = 1\n";

std::string use(std::string_view file) {
  return "format = 1\n[nodes]\np = { use = \"" + std::string{file} + "\" }\n";
}

std::string errors_of(const TemporaryFolder& folder, const std::filesystem::path& file,
                      const std::filesystem::path& root = {}) {
  const auto spec = load_graph(file, root);
  return folder.strip(test::summary(spec));
}

}  // namespace

TEST_CASE("parts: a file used twice is read once, whatever its path looks like", "[graph]") {
  const TemporaryFolder folder;
  folder.write("parts/string.toml", kEmpty);
  const auto file =
      folder.write("a.toml",
                   "format = 1\n[nodes]\na = { use = \"parts/string.toml\", pitch = 3 }\n"
                   "b = { use = \"parts/../parts/string.toml\" }\nc = { use = \"parts/string.toml\" }\n");
  const auto spec = load_graph(file);
  REQUIRE(spec);
  const auto& parts = (*spec)->parts;
  REQUIRE(parts.size() == 2);
  CHECK(parts.at("parts/string.toml") == parts.at("parts/../parts/string.toml"));
  CHECK(folder.strip(parts.at("parts/string.toml")->file.text()) == "parts/string.toml");
  CHECK((*spec)->nodes[0].fields.size() == 1);
}

TEST_CASE("parts: errors in all files come together, each file once", "[graph]") {
  const TemporaryFolder folder;
  folder.write("bad.toml", "format = 1\nnods = 1\n");
  folder.write("worse.toml", "format = ");
  const auto file =
      folder.write("a.toml",
                   "format = 1\n[nodes]\nx = { use = \"bad.toml\" }\ny = { use = \"worse.toml\" }\n"
                   "z = { use = \"bad.toml\" }\n1x = 3\n");
  CHECK(errors_of(folder, file) ==
        R"(a.toml:6:1 Syntax '1x'
bad.toml:2:1 UnknownName 'nods' 'nodes'
worse.toml:1:10 Syntax)");
}

TEST_CASE("parts: a circle of files is printed file by file", "[graph]") {
  const TemporaryFolder folder;
  const auto a = folder.write("a.toml", use("b.toml"));
  folder.write("b.toml", use("c.toml"));
  folder.write("c.toml", use("b.toml"));
  CHECK(errors_of(folder, a) == "c.toml:3:13 Cycle b.toml c.toml b.toml");
  const auto self = folder.write("self.toml", use("self.toml"));
  CHECK(errors_of(folder, self) == "self.toml:3:13 Cycle self.toml self.toml");
}

TEST_CASE("parts: no path leaves the root, not even through a link", "[graph]") {
  const TemporaryFolder folder;
  folder.write("parts/string.toml", kEmpty);
  folder.write("secret.toml", kEmpty);
  const auto file = folder.write("drum/a.toml", use("../parts/string.toml"));
  CHECK(errors_of(folder, file) == "drum/a.toml:3:13 OutOfRange '../parts/string.toml' 'drum'");
  CHECK(errors_of(folder, file, folder.path()) == "");
  folder.write("drum/a.toml", use("/etc/passwd"));
  CHECK(errors_of(folder, file) == "drum/a.toml:3:13 OutOfRange '/etc/passwd'");
  // A neighbour whose name begins like the root's is outside too.
  folder.write("drum_2/b.toml", kEmpty);
  folder.write("drum/a.toml", use("../drum_2/b.toml"));
  CHECK(errors_of(folder, file) == "drum/a.toml:3:13 OutOfRange '../drum_2/b.toml' 'drum'");
  folder.write("drum/a.toml", use("link.toml"));
  std::error_code no_links;
  std::filesystem::create_symlink(folder.path() / "secret.toml", folder.path() / "drum/link.toml", no_links);
  if (no_links) return test::skip_part("there are no symbolic links here");
  CHECK(errors_of(folder, file) == "drum/a.toml:3:13 OutOfRange 'link.toml' 'drum'");
}

TEST_CASE("parts: a missing file is reported where it is used, with the nearest one", "[graph]") {
  const TemporaryFolder folder;
  folder.write("string.toml", kEmpty);
  CHECK(errors_of(folder, folder.write("a.toml", use("strng.toml"))) ==
        "a.toml:3:13 BadFile 'strng.toml' 'string.toml'");
}

TEST_CASE("parts: paths in messages stay as the user gave them", "[graph]") {
  const auto spec = parse_graph(use("sub/../none.toml"), "some/./where.toml");
  REQUIRE_FALSE(spec);
  CHECK(test::summary(spec) == "some/./where.toml:3:13 BadFile 'some/none.toml'");
}

TEST_CASE("parts: a chain of files has an end", "[graph]") {
  const TemporaryFolder folder;
  for (int i = 0; i < 40; ++i)
    folder.write("p" + std::to_string(i) + ".toml", use("p" + std::to_string(i + 1) + ".toml"));
  CHECK(errors_of(folder, folder.path() / "p0.toml") == "p31.toml:3:13 OutOfRange 32");
}
