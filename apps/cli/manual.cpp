#include "apps/cli/manual.h"

#include <fmt/format.h>

#include <vector>

#include "apps/cli/console.h"

namespace tactus::app {
namespace {

/// Text as man(7) prints it: no macro at the start of a line, no escape.
std::string escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '.' && (escaped.empty() || escaped.back() == '\n')) escaped += "\\&";
    if (c == '-' || c == '\\') escaped += '\\';
    escaped += c == '\\' ? 'e' : c;
  }
  return escaped;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

/// Options of a command and of its groups, which are nameless commands.
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  auto options = app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
  for (const auto* group : app.get_subcommands([](const CLI::App* part) { return part->get_name().empty(); }))
    for (const auto* option : options_of(*group)) options.push_back(option);
  return options;
}

std::string title_of(const CLI::Option& option) {
  auto title = option.get_name(option.get_positional());
  if (const auto any = title.find("{*}"); any != std::string::npos) title.replace(any, 3, "[=NAME]");
  const bool value = !option.get_positional() && option.get_items_expected_max() > 0;
  return value ? title + " " + option.get_type_name() : title;
}

std::string description_of(const CLI::Option& option) {
  const auto value = option.get_default_str();
  return option.get_description() + (value.empty() ? "" : "; default: " + value);
}

void add_command(const CLI::App& command, const std::string& path, std::string& page) {
  page += fmt::format(".SS \"{}\"\n{}.\n", escaped(path), escaped(command.get_description()));
  for (const auto* option : options_of(command))
    if (option->get_name() != "--help" && option->get_name() != "-h,--help")
      page += fmt::format(".TP\n.B {}\n{}\n", escaped(title_of(*option)), escaped(description_of(*option)));
  if (const auto footer = command.get_footer(); !footer.empty())
    page += fmt::format(".PP\n.nf\n{}\n.fi\n", escaped(footer));
  for (const auto* inner : commands_of(command)) add_command(*inner, path + " " + inner->get_name(), page);
}

std::string words_of(const CLI::App& app) {
  std::string words;
  for (const auto* command : commands_of(app)) words += command->get_name() + " ";
  for (const auto* option : options_of(app))
    for (const auto& name : option->get_lnames()) words += "--" + name.substr(0, name.find('{')) + " ";
  return words;
}

/// A case for a command and for each below it, named "play", "latency measure".
void add_cases(const CLI::App& app, const std::string& path, std::string& cases) {
  for (const auto* command : commands_of(app)) {
    const auto name = path.empty() ? command->get_name() : path + " " + command->get_name();
    add_cases(*command, name, cases);
    cases += fmt::format("    \"{}\"*) words=\"{}\" ;;\n", name, words_of(*command));
  }
}

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string page = fmt::format(
      ".TH TACTUS 1 \"\" \"{}\" \"User Commands\"\n.SH NAME\ntactus \\- haptic instruments on sound cards\n"
      ".SH SYNOPSIS\n.B tactus\n.I COMMAND\n[options]\n.SH DESCRIPTION\n{}.\n{}\n.SH COMMANDS\n",
      version(), escaped(app.get_description()), escaped(app.get_footer()));
  for (const auto* command : commands_of(app)) add_command(*command, "tactus " + command->get_name(), page);
  return page +
         ".SH EXIT STATUS\n0: done. 1: an answer of no: a test failed, a drive was faded. 2: wrong usage. 3: "
         "errors "
         "in a file. 4: the device failed. 5: interrupted.\n";
}

std::string bash_completion(const CLI::App& app) {
  std::string cases;
  add_cases(app, "", cases);
  return fmt::format(R"(# Completion of tactus for bash: commands, options, files.
_tactus() {{
  local words current=${{COMP_WORDS[COMP_CWORD]}}
  case "${{COMP_WORDS[*]:1:COMP_CWORD}}" in
{}    *) words="{}" ;;
  esac
  if [[ $COMP_CWORD -gt 1 && $current != -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current"; compgen -f -- "$current")
    compopt -o filenames
  else
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  fi
}}
complete -F _tactus tactus
)",
                     cases, words_of(app));
}

}  // namespace tactus::app
