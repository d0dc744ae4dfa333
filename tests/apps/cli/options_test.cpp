#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "apps/cli/console.h"

using namespace tactus;
using namespace tactus::app;

namespace {

/// The whole program, made anew for each command line.
struct Program {
  Program() {
    for (auto* add : {add_play, add_list, add_new, add_actuators, add_render, add_check, add_explain,
                      add_export, add_study, add_sweep, add_nodes, add_devices, add_doctor, add_latency})
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

namespace {

/// The meaning of an option: its help up to the first ';' or ':'.
std::string meaning_of(const CLI::Option& option) {
  const auto& text = option.get_description();
  return text.substr(0, text.find_first_of(";:"));
}

void add_meanings(const CLI::App& command, std::map<std::string, std::set<std::string>>& meanings) {
  for (const auto* option : command.get_options())
    for (const auto& name : option->get_lnames()) meanings[name].insert(meaning_of(*option));
  for (const auto* inner : command.get_subcommands({})) add_meanings(*inner, meanings);
}

}  // namespace

TEST_CASE("options: a name means one thing in every command, and a thing has one name", "[apps]") {
  std::map<std::string, std::set<std::string>> meanings, names;
  const Program program;
  add_meanings(program.app, meanings);
  REQUIRE(meanings.size() > 60);
  for (const auto& [name, texts] : meanings) {
    if (name == "json") continue;   // print the report, list, reference as JSON
    if (name == "force") continue;  // of an actuator, a quantity; elsewhere: overwrite
    CAPTURE(name, texts);
    CHECK(texts.size() == 1);
    for (const auto& text : texts) names[text].insert(name);
  }
  for (const auto& [text, of] : names) {
    CAPTURE(text, of);
    CHECK(of.size() == 1);
  }
}

TEST_CASE("options: each has one spelling", "[apps]") {
  const Program program;
  std::vector<const CLI::App*> commands{&program.app};
  while (!commands.empty()) {
    const auto* command = commands.back();
    commands.pop_back();
    for (const auto* option : command->get_options()) {
      CAPTURE(command->get_name(), option->get_name(true, true));
      CHECK(option->get_lnames().size() <= 1);
    }
    for (const auto* inner : command->get_subcommands({})) commands.push_back(inner);
  }
}
