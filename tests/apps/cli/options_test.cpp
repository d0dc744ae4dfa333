#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "apps/cli/console.h"

using namespace tactus;
using namespace tactus::app;

namespace {

/// The whole program, made anew for each command line.
struct Program {
  Program() {
    for (auto* add : {add_play, add_render, add_check, add_explain, add_study, add_sweep, add_nodes,
                      add_devices, add_doctor, add_latency})
      add(app, exit_code);
    refuse_empty_texts(app);
  }
  std::string error_of(const std::vector<std::string>& words) {
    try {
      app.parse(std::vector<std::string>{words.rbegin(), words.rend()});
    } catch (const CLI::ParseError& error) {
      return error.get_name();
    }
    return "";
  }

  CLI::App app;
  int exit_code = 0;
};

/// All options with a value, after the names of their commands.
void add_options(const CLI::App& command, const std::vector<std::string>& path,
                 std::vector<std::vector<std::string>>& all) {
  for (const auto* option : command.get_options()) {
    if (option->get_items_expected_max() == 0 || option->get_lnames().empty()) continue;
    auto words = path;
    for (int n = 0; n < std::max(1, option->get_items_expected_min()); ++n) words.emplace_back();
    words.insert(words.begin() + std::ssize(path), "--" + option->get_lnames().front());
    all.push_back(words);
  }
  for (const auto* inner : command.get_subcommands({})) {
    auto words = path;
    if (!inner->get_name().empty()) words.push_back(inner->get_name());
    add_options(*inner, words, all);
  }
}

}  // namespace

TEST_CASE("options: none takes an empty text, which some would ignore", "[apps]") {
  std::vector<std::vector<std::string>> all;
  const Program program;
  add_options(program.app, {}, all);
  REQUIRE(all.size() > 100);
  for (const auto& words : all) {
    CAPTURE(words);
    CHECK(Program{}.error_of(words) == "ValidationError");
  }
}
