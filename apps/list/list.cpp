#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/cli/target.h"
#include "apps/cli/terminal.h"
#include "engine/graph/file/load.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

struct ListOptions {
  std::string folder;
  bool json = false;
};

struct Entry {
  std::string name;  ///< as `tactus play` takes it
  bool scene = false;
  std::string title, about;
};

std::string text_of(const Value::Table& table, const char* key) {
  const auto* value = find(table, key);
  const auto* text = value != nullptr ? value->text() : nullptr;
  return text != nullptr ? *text : std::string{};
}

/// Adds the files that a table uses as parts. The instrument of a scene is not one: it is listed.
void add_parts(const Value::Table& table, const fs::path& folder, std::set<fs::path>& parts) {
  for (const auto& [key, at, value] : table) {
    if (key == "use" && value.text() != nullptr) parts.insert((folder / *value.text()).lexically_normal());
    if (value.table() != nullptr && key != "instrument") add_parts(*value.table(), folder, parts);
  }
}

/// Whether a graph may be played by itself.
bool is_instrument(const Value::Table& table) {
  return find(table, "format") != nullptr && find(table, "outputs") != nullptr;
}

/// `shown`: what the names begin with instead of `folder`.
std::vector<Entry> entries_in(const fs::path& folder, const fs::path& shown) {
  std::error_code none;
  std::vector<fs::path> files;
  for (auto at = fs::recursive_directory_iterator{folder, none}; at != fs::recursive_directory_iterator{};
       at.increment(none)) {
    if (at.depth() > 2 || at->path().filename() == "profiles" || at->path().filename() == "templates")
      at.disable_recursion_pending();
    if (at->path().extension() == ".toml" && at->is_regular_file(none)) files.push_back(at->path());
  }
  std::ranges::sort(files);
  std::vector<std::pair<fs::path, Value::Table>> tables;
  std::set<fs::path> parts;
  for (const auto& file : files)
    if (auto table = load_toml(file)) {
      add_parts(*table, file.parent_path(), parts);
      tables.emplace_back(file, std::move(*table));
    }
  std::vector<Entry> entries;
  for (const auto& [file, table] : tables) {
    const bool scene = is_scene(table);
    if (!scene && (!is_instrument(table) || parts.contains(file.lexically_normal()))) continue;
    const auto name = (shown / file.lexically_relative(folder)).lexically_normal();
    entries.push_back({name.generic_string(), scene, text_of(table, "name"), text_of(table, "about")});
  }
  return entries;
}

void print(const char* heading, const std::vector<Entry>& entries, std::size_t columns) {
  if (entries.empty()) return;
  std::size_t width = 0;
  for (const auto& entry : entries) width = std::max(width, entry.name.size());
  fmt::print("{}\n", heading);
  for (const auto& entry : entries) {
    auto line =
        fmt::format("  {:<{}}  {:<10}  {}{}{}", entry.name, width, entry.scene ? "scene" : "instrument",
                    entry.title, entry.about.empty() ? "" : ": ", entry.about);
    if (columns > 0 && line.size() > columns) line = line.substr(0, columns - 3) + "...";
    fmt::print("{}\n", line);
  }
}

Json entry_json(const Entry& entry) {
  return {{"file", entry.name},
          {"kind", entry.scene ? "scene" : "instrument"},
          {"name", entry.title},
          {"about", entry.about}};
}

int run_list(const ListOptions& options) {
  const fs::path own = options.folder.empty() ? fs::path{"."} : fs::path{options.folder};
  std::error_code none;
  if (!fs::is_directory(own, none))
    exit_with({Errc::BadFile, own.generic_string(), "there is no such folder", "name a folder"}, kBadFile);
  const auto shipped = shipped_instruments();
  const bool same = fs::equivalent(own, shipped, none) || fs::equivalent(own / "instruments", shipped, none);
  const auto yours = same ? std::vector<Entry>{} : entries_in(own, options.folder);
  std::vector<Entry> installed;
  for (const auto& folder : instrument_folders())
    if (folder != shipped)
      for (auto& entry : entries_in(folder, "")) installed.push_back(std::move(entry));
  const auto ours = entries_in(shipped, "");
  if (options.json) {
    print_json({{"own", list_of(yours, entry_json)},
                {"installed", list_of(installed, entry_json)},
                {"shipped", list_of(ours, entry_json)}});
    return kDone;
  }
  const auto columns = static_cast<std::size_t>(std::max(0, terminal_columns()));
  print("in this folder", yours, columns);
  if (!yours.empty()) fmt::print("\n");
  print("installed by you", installed, columns);
  if (!installed.empty()) fmt::print("\n");
  print("shipped", ours, columns);
  fmt::print("\nplay one:  tactus play {}\n", !yours.empty() ? yours.front().name
                                              : ours.empty() ? "FILE"
                                                             : ours.front().name);
  return kDone;
}

}  // namespace

void add_list(CLI::App& app, int& exit_code) {
  auto [command, options] =
      add_command(app, "list", "List instruments and scenes: those of a folder, and the shipped ones",
                  exit_code, run_list);
  command.add_option("FOLDER", options.folder, "folder of your own; default: the current one");
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer("Examples:\n  tactus list\n  tactus list my_instruments");
}

}  // namespace tactus::app
