#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/table.h"

// Behaviour is a field of a table: generic code must not compare the names of what a table registers.

using namespace tactus;

namespace {

namespace fs = std::filesystem;

struct Found {
  std::string file;
  int line;
  std::string name;
};

/// Places where a registered name means something else.
struct Exception {
  std::string file, name, reason;
};
const std::vector<Exception> kExceptions = {
    {"engine/rig/limits.cpp", "slew", "a limit of an actuator"},
    {"engine/graph/semantics/bind.cpp", "curve", "a key of a spread over voices"},
    {"apps/play/live/performer.cpp", "strike", "the control of strikes by hand, as the documents say"},
};

std::vector<std::string> sources() {
  const fs::path root = TACTUS_SOURCE_DIR;
  std::vector<std::string> files;
  for (const auto* folder : {"engine", "backends", "latency", "remote", "apps", "python"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
        files.push_back(fs::relative(entry.path(), root).generic_string());
  std::sort(files.begin(), files.end());
  return files;
}

/// Types may compare their own settings; their table and the reference may not.
bool declares_types(const std::string& file) {
  return std::regex_match(file, std::regex("engine/nodes/[a-z]+/.*")) &&
         !file.starts_with("engine/nodes/networks/");
}

std::string text_of(const std::string& file) {
  std::ifstream in{fs::path{TACTUS_SOURCE_DIR} / file};
  return {std::istreambuf_iterator<char>{in}, {}};
}

/// What `pattern`, one group of which is a name, finds in `text`.
std::vector<Found> matches(const std::string& file, const std::string& text, const std::regex& pattern) {
  std::vector<Found> found;
  for (std::sregex_iterator match{text.begin(), text.end(), pattern}, end; match != end; ++match)
    for (std::size_t group = 1; group < match->size(); ++group)
      if ((*match)[group].matched)
        found.push_back(
            {file, 1 + static_cast<int>(std::count(text.begin(), text.begin() + match->position(), '\n')),
             (*match)[group]});
  return found;
}

/// Literals beside ==, != and inside starts_with("…").
std::vector<Found> compared(const std::string& file, const std::string& text) {
  static const std::regex pattern{
      "[=!]=\\s*\"([a-z_0-9.]+)\"|\"([a-z_0-9.]+)\"\\s*[=!]=|(?:starts|ends)_with\\(\"([a-z_0-9.]+)\""};
  return matches(file, text, pattern);
}

/// Ports that are looked up by a literal name.
std::vector<Found> looked_up(const std::string& file, const std::string& text) {
  static const std::regex pattern{"(?:in|out)put_index\\(\"([a-z_0-9]+)\""};
  return matches(file, text, pattern);
}

/// Controls that are looked up by a literal name.
std::vector<Found> looked_up_controls(const std::string& file, const std::string& text) {
  static const std::regex pattern{
      "controls,\\s*\"([a-z_0-9]+)\"|control_index\\(\"([a-z_0-9]+)\"|find_control\\([^;]*\"([a-z_0-9.]+)\""};
  return matches(file, text, pattern);
}

/// Names behind that of a part: ".gamma".
std::vector<Found> behind_dot(const std::string& file, const std::string& text) {
  static const std::regex pattern{"\"\\.([a-z_0-9]+)\""};
  return matches(file, text, pattern);
}

bool allowed(const Found& found) {
  return std::any_of(kExceptions.begin(), kExceptions.end(), [&](const Exception& exception) {
    return exception.file == found.file && exception.name == found.name;
  });
}

std::set<std::string> registered_types() {
  std::set<std::string> names;
  for (const auto* type : standard_nodes().types) names.insert(type->name);
  for (const auto& element : network_elements()) names.insert(element.name);
  return names;
}

std::set<std::string> registered_ports() {
  std::set<std::string> names;
  for (const auto* type : standard_nodes().types) {
    for (const auto& input : type->inputs) names.insert(input.name);
    for (const auto& output : type->outputs) names.insert(output.name);
  }
  return names;
}

/// Parts of shipped scenes, the names of nodes, elements and ports in all shipped files, and of controls.
struct ShippedNames {
  std::set<std::string> parts, inside, controls;
};

ShippedNames shipped_names() {
  static const std::regex section{"\\[([a-z_]+)(?:\\.([a-z_0-9]+))?(?:\\.([a-z_0-9]+))?\\].*"};
  static const std::regex entry{"([a-z_0-9]+) *= .*"};
  static const std::set<std::string> named = {"nodes", "inputs", "outputs", "controls"};
  ShippedNames names;
  for (const auto& file : fs::recursive_directory_iterator(fs::path{TACTUS_SOURCE_DIR} / "instruments")) {
    if (file.path().extension() != ".toml") continue;
    std::ifstream in{file.path()};
    std::smatch match;
    std::string head;
    bool whole = false;  // the entries of this section are names
    for (std::string line; std::getline(in, line);) {
      if (std::regex_match(line, match, section)) {
        head = match[1];
        whole = !match[2].matched || head == "networks";
        if (head == "parts" && match[2].matched) names.parts.insert(match[2]);
        if (named.contains(head) && match[2].matched) names.inside.insert(match[2]);
        if (head == "controls" && match[2].matched) names.controls.insert(match[2]);
      } else if (whole && std::regex_match(line, match, entry)) {
        if (head == "parts") names.parts.insert(match[1]);
        if (named.contains(head) || head == "networks") names.inside.insert(match[1]);
        if (head == "controls") names.controls.insert(match[1]);
      }
    }
  }
  return names;
}

std::string without_comments(const std::string& text) {
  return std::regex_replace(text, std::regex{"//[^\n]*"}, "");
}

std::string listed(const std::vector<Found>& all) {
  std::string text;
  for (const auto& one : all) text += one.file + ":" + std::to_string(one.line) + ": \"" + one.name + "\"\n";
  return text;
}

}  // namespace

TEST_CASE("tables: no generic code compares the name of a registered type", "[tables][layers]") {
  const auto names = registered_types();
  REQUIRE(names.size() > 30);
  std::vector<Found> wrong;
  for (const auto& file : sources()) {
    if (declares_types(file)) continue;
    for (const auto& found : compared(file, text_of(file)))
      if (names.contains(found.name) && !allowed(found)) wrong.push_back(found);
  }
  INFO("make it a field of the table's entry:\n" << listed(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("tables: no generic code looks a port up by its name", "[tables][layers]") {
  std::vector<Found> wrong;
  for (const auto& file : sources()) {
    if (file.starts_with("engine/nodes/")) continue;
    for (const auto& found : looked_up(file, text_of(file))) wrong.push_back(found);
  }
  INFO("make it a field of the port:\n" << listed(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("tables: no generic code names a node of a shipped scene", "[tables][layers]") {
  const auto names = shipped_names();
  REQUIRE(names.parts.contains("instrument"));
  REQUIRE(names.inside.contains("stick"));
  static const std::regex pattern{"\"([a-z_]+)\\.([a-z_0-9]+)\""};
  std::string wrong;
  for (const auto& file : sources()) {
    const auto text = without_comments(text_of(file));
    for (std::sregex_iterator match{text.begin(), text.end(), pattern}, end; match != end; ++match)
      if (names.parts.contains((*match)[1]) && names.inside.contains((*match)[2]))
        wrong += file + ": " + match->str() + "\n";
  }
  INFO("the scene says which port plays which role:\n" << wrong);
  CHECK(wrong.empty());
}

TEST_CASE("tables: no generic code names a control of a shipped file", "[tables][layers]") {
  const auto controls = shipped_names().controls;
  REQUIRE(controls.contains("gamma"));
  auto known = registered_ports();
  known.merge(registered_types());
  std::vector<Found> wrong;
  for (const auto& file : sources()) {
    if (declares_types(file)) continue;
    const auto text = without_comments(text_of(file));
    auto all = looked_up_controls(file, text);
    for (const auto& others : {compared(file, text), behind_dot(file, text)})
      std::ranges::copy_if(others, std::back_inserter(all), [&](const Found& found) {
        return !known.contains(found.name.substr(found.name.rfind('.') + 1));
      });
    for (auto found : all) {
      found.name = found.name.substr(found.name.rfind('.') + 1);
      if (controls.contains(found.name) && !allowed(found)) wrong.push_back(found);
    }
  }
  INFO("the scene says which control plays which role:\n" << listed(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("tables: comparisons are found in any form", "[tables][layers]") {
  const std::string text = "if (a == \"mix\") b;\nif (\"hold\" != c) d;\n e = name.starts_with(\"delay\");";
  const auto found = compared("a.cpp", text);
  REQUIRE(found.size() == 3);
  CHECK(found[0].name == "mix");
  CHECK(found[1].name == "hold");
  CHECK(found[1].line == 2);
  CHECK(found[2].name == "delay");
  CHECK(looked_up("a.cpp", "type.input_index(\"hold\")").front().name == "hold");
  const std::string controls =
      "find_named(part->graph->controls, \"rate\"); find_control(scene, \"plant.mass\");";
  const auto named = looked_up_controls("a.cpp", controls);
  REQUIRE(named.size() == 2);
  CHECK(named[0].name == "rate");
  CHECK(named[1].name == "plant.mass");
  CHECK(behind_dot("a.cpp", "name + \".gamma\"").front().name == "gamma");
}
