#include "apps/cli/console.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <fstream>

#include "apps/cli/json.h"
#include "apps/cli/terminal.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

// Other threads read it, too.
std::atomic<bool> signalled{false};
static_assert(std::atomic<bool>::is_always_lock_free);
extern "C" void note_signal(int) { signalled.store(true, std::memory_order_relaxed); }

bool opens(const fs::path& file) {
  std::error_code none;
  const auto kind = fs::status(file, none).type();
  if (kind == fs::file_type::directory) return false;
  // A pipe would wait for its reader.
  if (kind != fs::file_type::not_found && kind != fs::file_type::regular) return true;
  const bool opened = std::ofstream{file, std::ios::app}.is_open();
  if (kind == fs::file_type::not_found) fs::remove(file, none);
  return opened;
}

bool opens_into(const fs::path& folder) {
  std::error_code none;
  auto there = fs::absolute(folder, none).lexically_normal();
  while (!fs::exists(there, none) && there.has_relative_path()) there = there.parent_path();
  return fs::is_directory(there, none) && opens(there / ".tactus_tries_to_write");
}

CLI::Validator writable_if(bool (*writable)(const fs::path&), const char* remedy) {
  return {[=](const std::string& text) {
            return text.empty() || writable(text) ? "" : text + ": cannot be written; " + remedy;
          },
          ""};
}

}  // namespace

const char* version() { return "tactus " TACTUS_VERSION; }

CLI::App& add_command_group(CLI::App& app, const char* name, const char* help, const char* footer) {
  auto* group = app.add_subcommand(name, help);
  group->require_subcommand(0, 1);
  group->footer(footer);
  group->callback([group] {
    if (group->get_subcommands().empty()) fmt::print("{}", group->help("tactus"));
  });
  return *group;
}

void refuse_empty_texts(CLI::App& app) {
  for (auto* option : app.get_options())
    if (option->get_items_expected_max() > 0)
      option->check([](const std::string& text) {
        return text.empty() ? "the text is empty; give a value, or leave the option out" : std::string{};
      });
  for (auto* command : app.get_subcommands({})) refuse_empty_texts(*command);
}

CLI::Validator writable_file() { return writable_if(opens, "choose a file in an existing, writable folder"); }
CLI::Validator writable_folder() { return writable_if(opens_into, "choose a writable folder"); }

int report(const CommandError& error, bool as_json) {
  const auto& errors = error.errors;
  if (as_json) print_json({{"errors", errors_json(errors)}});
  print_note(errors.empty() ? "interrupted" : to_string(errors));
  if (error.exit != 0) return error.exit;
  const bool in_a_file = std::ranges::count(errors, Error::Place::File, &Error::place) > 0;
  return in_a_file ? kBadFile : kUsage;
}

void check_commands(const CLI::App& app, const std::vector<std::string>& words) {
  // Groups of options are nameless commands.
  const auto commands =
      app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
  if (words.empty() || words.front().starts_with("-") || commands.empty()) return;
  std::vector<std::string> names;
  for (const auto* command : commands) {
    if (command->get_name() == words.front())
      return check_commands(*command, {words.begin() + 1, words.end()});
    names.push_back(command->get_name());
  }
  const auto& group = app.get_name();
  const auto& word = words.front();
  if (app.get_parent() != nullptr && (word.find_first_of("/.") != std::string::npos || fs::exists(word)))
    exit_with({Errc::Missing, "", fmt::format("'{} {}' names no {}", group, word, group),
               fmt::format("write tactus {} NAME {}, where NAME is {}", group, word, fmt::join(names, ", "))},
              kUsage);
  exit_with({Errc::UnknownName, "",
             fmt::format("there is no command '{}{}'", app.get_parent() != nullptr ? group + " " : "",
                         words.front()),
             suggest(words.front(), names, fmt::format("there are {}", fmt::join(names, ", ")))},
            kUsage);
}

Error out_of_memory(const std::string& what) {
  return {
      Errc::OutOfRange, "", "there is not enough memory for " + what,
      "use fewer lanes and nodes, shorter delays, recordings and scenes, or allow the program more memory "
      "(ulimit -v, other programs)"};
}

int exit_of(const Error& error) {
  return error.code == Errc::BadArgument || error.code == Errc::OutOfRange ? kUsage : kDevice;
}

void install_signal_handlers() {
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
#ifdef SIGHUP
  if (std::signal(SIGHUP, note_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // as nohup asks for
#endif
}

bool interrupted() { return signalled.load(std::memory_order_relaxed); }

void print_note(const std::string& text) noexcept { std::fprintf(stderr, "%s\n", text.c_str()); }

Progress::Progress(std::string what) : what_(std::move(what)) {
  if (terminal_columns() > 0) printer_.emplace();
}

void Progress::operator()(double share, const std::string& what) {
  const bool renamed = !what.empty() && what != std::exchange(what_, what);
  const int percent = static_cast<int>(share * 100);
  if (!printer_ || (percent == percent_ && !renamed)) return;
  percent_ = percent;
  const int full = percent * 30 / 100;
  printer_->status(fmt::format("{} [{:=<{}}{: <{}}] {:3} %", what_, "", full, "", 30 - full, percent));
}

std::string delay_warning(const GraphSpec& instrument, double delay_s) {
  const auto& tested = instrument.tested;
  if (!tested || tested->contains(delay_s)) return {};
  const auto text = [](double si) { return short_quantity(si, Dimension{.second = 1}); };
  return fmt::format(
      "warning: {} was tested with system delays from {} to {}; with {} it may not be playable",
      instrument.name, text(tested->low), text(tested->high), text(delay_s));
}

void announce_delay(const GraphSpec& instrument, double delay_s) {
  if (const auto warning = delay_warning(instrument, delay_s); !warning.empty()) print_note(warning);
}

std::pair<std::string, std::string> parse_assignment(const std::string& text, const char* option,
                                                     const std::string& form, const std::string& example) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    exit_with(
        {Errc::Syntax, option, "'" + text + "' is not of the form " + form, "write for instance " + example});
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::map<std::string, ControlValue> parse_settings(const std::vector<std::string>& texts) {
  std::map<std::string, ControlValue> settings;
  for (const auto& assignment : texts) {
    const auto [name, text] =
        parse_assignment(assignment, "--set", "NAME=VALUE", "strength=0.5 or \"sensitivity=-40 dB\"");
    const auto value = read_quantity(Value{text, {}});
    if (!value) exit_with(value.error().at("--set"));
    settings[name] = *value;
  }
  return settings;
}

double parse_option(const std::string& text, const char* unit, const std::string& option, double least,
                    double most) {
  const auto known_unit = *parse_unit(unit);
  auto value = read_quantity(Value{text, {}}, known_unit, option);
  if (!value) exit_with(value.error().at("--" + option));
  if (*value >= least && *value <= most) return *value;
  const bool sign = least == kAboveZero && *value <= 0;
  const bool milliseconds = std::string_view{unit} == "s" &&
                            text.find_first_not_of("0123456789. ") == text.npos && *value > most &&
                            *value <= 1e3 * most;
  exit_with({Errc::OutOfRange, "--" + option, "'" + text + "' is out of range",
             sign           ? "it must be above 0"
             : milliseconds ? fmt::format("{0} counts as {0} s; write \"{0} ms\"", text)
                            : limits_text(least, most, known_unit)});
}

}  // namespace tactus::app
