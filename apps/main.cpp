#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "apps/cli/console.h"
#include "apps/cli/manual.h"
#include "apps/cli/terminal.h"

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
    return option->get_description() + (value.empty() ? "" : "; default: " + value);
  }
};

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
    return app.exit(error) == 0 ? kDone : kUsage;
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
