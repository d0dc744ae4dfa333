
#include <catch2/catch.hpp>

#include "engine/graph/file/load.h"
#include "tests/support/messages.h"
#include "tests/support/parse_graph.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using tactus::test::parse_graph;
using test::TemporaryFolder;

namespace {

constexpr auto kEmpty = "format = 1\n";

std::string use(std::string_view file) {
  return "format = 1\n[nodes]\np = { use = \"" + std::string{file} + "\" }\n";
}

test::Messages mistakes(const TemporaryFolder& folder, const std::filesystem::path& file,
                        const std::filesystem::path& root = {}) {
  const auto spec = load_graph(file, root);
  return spec ? "" : folder.strip(to_string(spec.error()));
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

TEST_CASE("parts: mistakes in all files come together, each file once", "[graph]") {
  const TemporaryFolder folder;
  folder.write("bad.toml", "format = 1\nnods = 1\n");
  folder.write("worse.toml", "format = ");
  const auto file =
      folder.write("a.toml",
                   "format = 1\n[nodes]\nx = { use = \"bad.toml\" }\ny = { use = \"worse.toml\" }\n"
                   "z = { use = \"bad.toml\" }\n1x = 3\n");
  CHECK(mistakes(folder, file) ==
        "a.toml:6:1: '1x' cannot name a node; names begin with a lower-case letter, followed by lower-case "
        "letters, "
        "digits "
        "and _\n"
        "bad.toml:2:1: unknown key 'nods'; did you mean 'nodes'?\n"
        "worse.toml:1:10: in this key-value pair: encountered end-of-file; fix this to see further errors");
}

TEST_CASE("parts: a circle of files is printed file by file", "[graph]") {
  const TemporaryFolder folder;
  const auto a = folder.write("a.toml", use("b.toml"));
  folder.write("b.toml", use("c.toml"));
  folder.write("c.toml", use("b.toml"));
  CHECK(mistakes(folder, a) ==
        "c.toml:3:13: a file includes itself: b.toml -> c.toml -> b.toml; remove one of these parts from its "
        "file");
  const auto self = folder.write("self.toml", use("self.toml"));
  CHECK(mistakes(folder, self) ==
        "self.toml:3:13: a file includes itself: self.toml -> self.toml; remove one of these parts from its "
        "file");
}

TEST_CASE("parts: no path leaves the root, not even through a link", "[graph]") {
  const TemporaryFolder folder;
  folder.write("parts/string.toml", kEmpty);
  folder.write("secret.toml", kEmpty);
  const auto file = folder.write("drum/a.toml", use("../parts/string.toml"));
  CHECK(mistakes(folder, file) ==
        "drum/a.toml:3:13: '../parts/string.toml' is outside the folder 'drum'; keep the files of an "
        "instrument "
        "inside it");
  CHECK(mistakes(folder, file, folder.path()) == "");
  folder.write("drum/a.toml", use("/etc/passwd"));
  CHECK(mistakes(folder, file) ==
        "drum/a.toml:3:13: '/etc/passwd' is an absolute path; give the path relative to this file");
  folder.write("drum/a.toml", use("link.toml"));
  std::filesystem::create_symlink(folder.path() / "secret.toml", folder.path() / "drum/link.toml");
  CHECK(mistakes(folder, file) ==
        "drum/a.toml:3:13: 'link.toml' is outside the folder 'drum'; keep the files of an instrument "
        "inside it");
  // A neighbour whose name begins like the root's is outside too.
  folder.write("drum_2/b.toml", kEmpty);
  folder.write("drum/a.toml", use("../drum_2/b.toml"));
  CHECK(mistakes(folder, file).find("is outside the folder 'drum'") != std::string::npos);
}

TEST_CASE("parts: a missing file is reported where it is used, with the nearest one", "[graph]") {
  const TemporaryFolder folder;
  folder.write("string.toml", kEmpty);
  CHECK(mistakes(folder, folder.write("a.toml", use("strng.toml"))) ==
        "a.toml:3:13: there is no file 'strng.toml'; did you mean 'string.toml'?");
}

TEST_CASE("parts: paths in messages stay as the user gave them", "[graph]") {
  const auto spec = parse_graph(use("sub/../none.toml"), "some/./where.toml");
  REQUIRE_FALSE(spec);
  CHECK(to_string(spec.error()) ==
        "some/./where.toml:3:13: there is no file 'some/none.toml'; paths are relative to this file");
}

TEST_CASE("parts: a chain of files has an end", "[graph]") {
  const TemporaryFolder folder;
  for (int i = 0; i < 40; ++i)
    folder.write("p" + std::to_string(i) + ".toml", use("p" + std::to_string(i + 1) + ".toml"));
  CHECK(mistakes(folder, folder.path() / "p0.toml") ==
        "p31.toml:3:13: parts are nested more than 32 files deep; use fewer levels");
}
