#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
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

TEST_CASE("docs: the schema refers to definitions that it has, and has every node type and section",
          "[docs]") {
  const auto schema = nlohmann::json::parse(file_schema(standard_nodes()));
  const auto& definitions = schema["definitions"];
  const auto text = schema.dump();
  const std::regex reference{R"re("#/definitions/(\w+)")re"};
  for (std::sregex_iterator it{text.begin(), text.end(), reference}, end; it != end; ++it)
    CHECK(definitions.contains((*it)[1].str()));
  for (const auto* type : standard_nodes().types) CHECK(definitions.contains("node_" + type->name));
  for (const auto* section :
       {"parts", "gestures", "roles", "expect", "accuracy", "playability", "ports", "drives"})
    CHECK(definitions["scene"]["properties"].contains(section));
}

TEST_CASE("docs: every shipped graph file names the schema in its first line", "[docs]") {
  const fs::path root = TACTUS_SOURCE_DIR;
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / "instruments")) {
    const auto text = entry.path().extension() == ".toml" ? text_of(entry.path()) : "";
    if (text.find("format") == std::string::npos) continue;
    if (entry.path().parent_path().filename() == "figures") continue;  // of actuators: no graphs
    ++files;
    const std::string directive = "#:schema ";
    INFO(entry.path());
    REQUIRE(text.starts_with(directive));
    const auto named = text.substr(directive.size(), text.find('\n') - directive.size());
    CHECK((entry.path().parent_path() / named).lexically_normal() ==
          (root / "docs/tactus.schema.json").lexically_normal());
  }
  CHECK(files > 0);
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
