#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>

#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"

// The shipped files, each with one key changed.

using namespace tactus;

namespace {

/// Instruments, plants and parts, no scenes.
std::vector<std::filesystem::path> shipped_graphs() {
  std::vector<std::filesystem::path> files;
  const auto folder = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";
  for (const auto& entry : std::filesystem::recursive_directory_iterator{folder})
    if (entry.path().extension() == ".toml" && load_graph_leniently(entry.path()).spec)
      files.push_back(entry);
  std::ranges::sort(files);
  return files;
}

/// Compiles a changed file as if it stood beside its parts. What is wrong with it is reported with its place,
/// and nothing else happens.
bool holds(const std::string& text, const std::filesystem::path& file) {
  const auto plan = compile(parse_graph_leniently(text, file.string()), standard_nodes(), {});
  if (plan) return true;
  const auto tells = [](const Error& error) {
    return error.where.find(".toml") != std::string::npos && !error.what.empty();
  };
  return !plan.error().empty() && std::ranges::all_of(plan.error(), tells);
}

}  // namespace

TEST_CASE("changed files: a key that is missing, misspelt or of another kind is reported", "[graph]") {
  const std::regex pair{R"re((\w+) = ("[^"\n]*"|[-+.\w]+|\[[^\]\n]*\]))re"};
  std::size_t keys = 0;
  for (const auto& file : shipped_graphs()) {
    INFO(file.string());
    const auto text = read_graph_text(file).value();
    if (!compile(parse_graph_leniently(text, file.string()), standard_nodes(), {})) continue;
    for (std::sregex_iterator at{text.begin(), text.end(), pair}, end; at != end; ++at) {
      const auto& found = *at;
      const std::string key = found[1], value = found[2];
      const std::string changes[] = {"zz = 0",      key + "q = " + value, key + " = 1",    key + " = \"a\"",
                                     key + " = []", key + " = {}",        key + " = -1e30"};
      const auto& change = changes[keys++ % std::size(changes)];  // each of them at each 7th key
      auto changed = text;
      changed.replace(static_cast<std::size_t>(found.position()), static_cast<std::size_t>(found.length()),
                      change);
      CAPTURE(found.str(), change);
      REQUIRE(holds(changed, file));
    }
  }
  CHECK(keys > 3000);
}
