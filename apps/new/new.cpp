#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "apps/cli/console.h"
#include "apps/cli/target.h"
#include "engine/core/files.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/load.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDefaultTemplate = "knob";

struct NewOptions {
  std::string folder;
  std::string from = kDefaultTemplate;
};

fs::path templates() { return shipped_instruments() / "templates"; }

std::vector<std::string> template_names() {
  std::error_code none;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator{templates(), none})
    if (fs::exists(entry.path() / "instrument.toml", none)) names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

std::string about_of(const std::string& name) {
  const auto graph = load_graph(templates() / name / "instrument.toml");
  return graph ? (*graph)->about : std::string{};
}

/// The file of a template for another place: the schema of the installation, which editors read, and in the
/// instrument its new name.
std::string adapted(std::string text, const std::string& name, bool instrument) {
  const auto schema = shipped_instruments().parent_path() / "docs/tactus.schema.json";
  std::error_code none;
  const auto line = fs::exists(schema, none) ? "#:schema " + schema.generic_string() + "\n" : std::string{};
  text = std::regex_replace(text, std::regex{"^#:schema [^\n]*\n"}, line,
                            std::regex_constants::format_first_only);
  if (!instrument) return text;
  return std::regex_replace(text, std::regex{"\nname( *)= \"[^\"]*\""}, "\nname$1= \"" + name + "\"",
                            std::regex_constants::format_first_only);
}

std::string readme(const std::string& name, const std::string& folder, const std::string& about) {
  return fmt::format(
      "# {0}\n\n{2}\n\n"
      "    tactus play {1}                      # simulate the scene: report, plot and sound files in out/\n"
      "    tactus play {1} --listen             # hear it in real time; edit a file, and the sound follows\n"
      "    tactus check {1}                     # is it stable?\n"
      "    tactus play {1} --device default     # on a sound card; the drives are disarmed at first\n\n"
      "| file | contents |\n|---|---|\n"
      "| `instrument.toml` | the instrument: inputs, controls, nodes, outputs |\n"
      "{3}"
      "| `scene.toml` | a performance in simulation, with what is expected of it |\n",
      name, folder, about,
      fs::exists(fs::path{folder} / "plant.toml")
          ? "| `plant.toml` | the simulated hardware and hand that the instrument is tried on |\n"
          : "");
}

/// Characters that need no quotes in a file or on a command line.
void check_name(const std::string& name) {
  const auto good = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == ' '; };
  if (name.empty() || !std::ranges::all_of(name, good))
    exit_with({Errc::BadArgument, "", "'" + name + "' cannot be the name of an instrument",
               "use letters, digits, '_' and '-'"});
}

int run_new(const NewOptions& options) {
  const auto names = template_names();
  if (std::ranges::find(names, options.from) == names.end())
    exit_with({Errc::UnknownName, "--from", "there is no template '" + options.from + "'",
               suggest(options.from, names, fmt::format("there are {}", fmt::join(names, ", ")))});
  auto folder = fs::path{options.folder}.lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  const auto name = folder.filename().string();
  check_name(name);
  std::error_code error;
  if (fs::exists(folder, error))
    exit_with({Errc::BadFile, folder.generic_string(), "already exists", "choose another name"}, kBadFile);
  if (!fs::create_directories(folder, error))
    exit_with({Errc::BadFile, folder.generic_string(), "cannot be created", "choose a writable folder"},
              kBadFile);
  for (const auto& entry : fs::directory_iterator{templates() / options.from}) {
    const auto file = entry.path().filename();
    or_exit(write_file(folder / file,
                       adapted(or_exit(read_graph_text(entry.path())), name, file == "instrument.toml")));
  }
  const auto path = folder.generic_string();
  or_exit(write_file(folder / "README.md", readme(name, path, about_of(options.from))));
  fmt::print("{} is made from the template '{}'\n\n", path, options.from);
  fmt::print(
      "play it:        tactus play {0}\nhear it:        tactus play {0} --listen\nchange it:      edit "
      "{0}/instrument.toml\n",
      path);
  return kDone;
}

std::string list_of_templates() {
  std::string text = "Templates:\n";
  for (const auto& name : template_names()) text += fmt::format("  {:<13} {}\n", name, about_of(name));
  return text;
}

}  // namespace

void add_new(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(
      app, "new", "Make a folder with an instrument of your own, from a template", exit_code, run_new);
  command.add_option("NAME", options.folder, "folder to make; its name is that of the instrument")
      ->required();
  command.add_option("--from", options.from, "template")->capture_default_str();
  command.footer([] {  // reads files, and only where somebody reads it
    return "Examples:\n  tactus new my_knob\n  tactus new shakers/waltz --from metronome\n\n" +
           list_of_templates();
  });
}

}  // namespace tactus::app
