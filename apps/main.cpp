#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <sstream>
#include <string>
#include <vector>

#include "apps/cli/console.h"
#include "apps/cli/manual.h"
#include "apps/cli/terminal.h"
#include "engine/graph/file/error_list.h"

namespace {

/// The help of CLI11 with its defaults at the end of each description.
class HelpFormatter : public CLI::Formatter {
  std::string make_option_name(const CLI::Option* option, bool positional) const override {
    auto name = CLI::Formatter::make_option_name(option, positional);
    const auto any = name.find("{*}");  // a flag that accepts a value
    return any == std::string::npos ? name : name.replace(any, 3, "[=NAME]");
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    auto text = CLI::Formatter::make_option_opts(option);
    const auto value = "=" + option->get_default_str();
    const auto at = value.size() > 1 ? text.find(value) : std::string::npos;
    return at == std::string::npos ? text : text.erase(at, value.size());
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    const auto value = option->get_default_str();
    return wrapped(option->get_description() + (value.empty() ? "" : "; default: " + value));
  }

  /// For the column of descriptions on 100 columns.
  std::string wrapped(std::string text) const {
    const auto width = 98 - get_column_width();
    for (std::size_t start = 0; text.size() - start > width;) {
      const auto space = text.rfind(' ', start + width);
      if (space == std::string::npos || space <= start) break;
      text[space] = '\n';
      start = space + 1;
    }
    return text;
  }
};

/// The command that was called.
const CLI::App& called(const CLI::App& app) {
  const auto inner = app.get_subcommands();
  return inner.empty() ? app : called(*inner.front());
}

void add_option_names(const CLI::App& command, std::vector<std::string>& names) {
  for (const auto* option : command.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  for (const auto* group :
       command.get_subcommands([](const CLI::App* inner) { return inner->get_name().empty(); }))
    add_option_names(*group, names);
}

/// What is wrong with the command line; of an unknown option with the nearest one of its command.
tactus::Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const bool unknown = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  std::istringstream unexpected{unknown ? error.what() : ""};
  for (std::string word; unexpected >> word;) {
    if (!word.starts_with("--")) continue;
    const auto name = word.substr(0, word.find('='));
    std::vector<std::string> names;
    add_option_names(called(app), names);
    return {tactus::Errc::UnknownName, "", "there is no option '" + name + "'",
            tactus::suggest(name, names, "see --help")};
  }
  return {tactus::Errc::Syntax, "", error.what(), "see --help"};
}

/// An option for packages, not in the help: prints a text and ends.
void add_hidden_text(CLI::App& app, const char* option, std::string (*text)(const CLI::App&)) {
  const auto print = [&app, text] {
    std::fputs(text(app).c_str(), stdout);
    throw CLI::Success{};
  };
  app.add_flag_callback(option, print)->group("");
}

}  // namespace

static int run(int argc, char** argv) {
  using namespace tactus::app;
  open_standard_streams();
  CLI::App app{"Tactus: haptic instruments on ordinary sound cards", "tactus"};
  app.formatter(std::make_shared<HelpFormatter>());
  app.require_subcommand(1);
  app.set_version_flag("--version", version());
  app.footer("Start with:  tactus play instruments/haptic_drum\nHelp on a command:  tactus render --help");
  int exit_code = kDone;
  for (auto* add : {TACTUS_COMMANDS}) add(app, exit_code);  // as apps/CMakeLists.txt says
  refuse_empty_texts(app);
  add_hidden_text(app, "--man", man_page);
  add_hidden_text(app, "--bash-completion", bash_completion);
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool as_json = std::ranges::count(words, "--json") > 0;
  if (!words.empty() && words.front() == "help") {  // as "COMMAND --help"
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  try {
    check_commands(app, words);
    std::ranges::reverse(words);  // as CLI11 wants them
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return report({{usage_error(app, error)}, kUsage}, as_json);
  } catch (const CommandError& error) {
    return report(error, as_json);
  } catch (const std::bad_alloc&) {
    return report({{out_of_memory("what this command was given")}, kNo});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tactus: %s\n", error.what());
    return kNo;
  }
  return exit_code;
}

/// Without the destructors of static objects, libraries' included: threads that still wait in a library or
/// for a file system use them. (The address sanitizer looks for leaks after main.)
int main(int argc, char** argv) {
  const int exit_code = run(argc, argv);
#if !defined(TACTUS_SANITIZED)
  std::cout.flush();
  std::fflush(stdout);
  std::_Exit(exit_code);
#endif
  return exit_code;
}
