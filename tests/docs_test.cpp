#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "apps/nodes/schema.h"
#include "engine/nodes/reference.h"
#include "engine/nodes/table.h"

using namespace tactus;

namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream file{path};
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("docs: the reference of nodes is what the declarations say", "[docs]") {
  INFO("docs/nodes.md is out of date; renew it with: scripts/renew_docs");
  const bool current =
      text_of(fs::path{TACTUS_SOURCE_DIR} / "docs/nodes.md") == reference_markdown(standard_nodes());
  CHECK(current);
}

TEST_CASE("docs: the schema of graph files is what the declarations say", "[docs]") {
  INFO("docs/tactus.schema.json is out of date; renew it with: scripts/renew_docs");
  const bool current =
      text_of(fs::path{TACTUS_SOURCE_DIR} / "docs/tactus.schema.json") == file_schema(standard_nodes());
  CHECK(current);
}

TEST_CASE("docs: every shipped graph file names the schema in its first line", "[docs]") {
  const fs::path root = TACTUS_SOURCE_DIR;
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / "instruments")) {
    const auto text = entry.path().extension() == ".toml" ? text_of(entry.path()) : "";
    if (text.find("format") == std::string::npos) continue;
    ++files;
    const std::string directive = "#:schema ";
    INFO(entry.path());
    REQUIRE(text.starts_with(directive));
    const auto named = text.substr(directive.size(), text.find('\n') - directive.size());
    CHECK(fs::equivalent(entry.path().parent_path() / named, root / "docs/tactus.schema.json"));
  }
  CHECK(files > 0);
}

TEST_CASE("docs: links between files lead somewhere", "[docs]") {
  const fs::path root = TACTUS_SOURCE_DIR;
  std::vector<fs::path> pages = {root / "README.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  const std::regex link{R"(\]\(([^)#\s]+)[^)\s]*\))"};  // a lambda in an example has spaces
  int links = 0;
  for (const auto& page : pages) {
    const auto text = text_of(page);
    for (std::sregex_iterator it{text.begin(), text.end(), link}, end; it != end; ++it) {
      const auto target = (*it)[1].str();
      if (target.find("://") != std::string::npos) continue;
      ++links;
      INFO(page.filename().string() << ": " << target);
      CHECK(fs::exists(page.parent_path() / target));
    }
  }
  CHECK(links > 3);
}

TEST_CASE("docs: the reference as text is at most 100 columns wide, but for examples", "[docs]") {
  for (const auto* type : standard_nodes().types) {
    std::istringstream text{reference_text(*type)};
    for (std::string line; std::getline(text, line);) {
      const auto columns = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
      INFO(type->name << ": " << line);
      CHECK((columns <= 100 || line.find(type->example) != std::string::npos));
    }
  }
}
