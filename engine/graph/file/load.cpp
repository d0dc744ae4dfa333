#include "engine/graph/file/load.h"

#include <algorithm>
#include <map>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

namespace fs = std::filesystem;

bool inside(const fs::path& path, const fs::path& root) {
  const auto relative = path.lexically_relative(root);
  return !relative.empty() && *relative.begin() != "..";
}

std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry{folder, error}, end; !error && entry != end; entry.increment(error))
    names.push_back(entry->path().filename().generic_string());
  return names;
}

using Spec = std::shared_ptr<const GraphSpec>;

// Nobody nests parts so deep; each level costs stack.
constexpr std::size_t kLoadMaxDepth = 32;

/// Reads a file and all that it uses, each file once.
class Loader {
 public:
  Loader(const fs::path& file, const fs::path& root)
      : root_(root.empty() ? file.parent_path() : root),
        errors_(Source{std::make_shared<const std::string>(file.generic_string()), 0, 0}) {}

  Spec build(const PartPath& path, const Result<std::string>& text) {
    if (errors_.keep(text) == nullptr) return nullptr;
    texts_[path.name] = *text;
    const auto table = parse_toml(*text, path.name);
    if (errors_.keep(table) == nullptr) return nullptr;
    const Source file{std::make_shared<const std::string>(path.name), 0, 0};
    auto spec = std::make_shared<GraphSpec>(read_graph(*table, file, errors_));
    open_.push_back(path);
    for (const auto& node : spec->nodes)
      if (!node.use.empty())
        if (auto part = use(node)) spec->parts[node.use] = std::move(part);
    open_.pop_back();
    return spec;
  }

  std::vector<Error> take_errors() { return errors_.take(); }
  std::map<std::string, std::string> take_texts() { return std::move(texts_); }

 private:
  Spec use(const NodeSpec& node) {
    const auto folder = fs::path{open_.back().name}.parent_path();
    const auto found = find_part(node.use, folder, root_, node.type_at);
    const auto* path = errors_.keep(found);
    if (path == nullptr || runs_in_circle(*path, node) || too_deep(node)) return nullptr;
    const auto known = done_.find(path->canonical);
    if (known != done_.end()) {
      texts_[path->name] = texts_[known->second.name];
      return known->second.spec;
    }
    // A file with errors is remembered too, so that it reports them once.
    return (done_[path->canonical] = {build(*path, read_graph_text(path->name)), path->name}).spec;
  }

  bool runs_in_circle(const PartPath& path, const NodeSpec& node) {
    const auto first = std::find_if(open_.begin(), open_.end(),
                                    [&](const PartPath& open) { return open.canonical == path.canonical; });
    if (first == open_.end()) return false;
    std::string chain;
    for (auto file = first; file != open_.end(); ++file) chain += file->name + " -> ";
    errors_.add(Errc::Cycle, node.type_at, "a file includes itself: " + chain + first->name,
                "remove one of these parts from its file");
    return true;
  }

  bool too_deep(const NodeSpec& node) {
    if (open_.size() < kLoadMaxDepth) return false;
    errors_.add(Errc::OutOfRange, node.type_at, "parts are nested more than 32 files deep",
                "use fewer levels");
    return true;
  }

  struct Done {
    Spec spec;
    std::string name;  ///< under which it was opened first
  };

  fs::path root_;
  ErrorList errors_;
  std::vector<PartPath> open_;  ///< from the first file to the one that is being read
  std::map<fs::path, Done> done_;
  std::map<std::string, std::string> texts_;  ///< by name
};

LoadedGraph read(const fs::path& file, const fs::path& root, const Result<std::string>& text) {
  Loader loader{file, root};
  auto spec = loader.build({file.generic_string(), canonical_path(file)}, text);
  return {std::move(spec), loader.take_errors(), loader.take_texts()};
}

}  // namespace

LoadedGraph load_graph_leniently(const fs::path& file, const fs::path& root) {
  return read(file, root, read_graph_text(file));
}

LoadedGraph parse_graph_leniently(std::string_view text, const std::string& file_name, const fs::path& root) {
  return read(file_name, root, std::string{text});
}

Checked<Spec> load_graph(const fs::path& file, const fs::path& root) {
  auto loaded = load_graph_leniently(file, root);
  if (!loaded.errors.empty()) return tl::unexpected(std::move(loaded.errors));
  return std::move(loaded.spec);
}

fs::path canonical_path(const fs::path& path) {
  std::error_code error;
  const auto absolute = fs::absolute(path.empty() ? fs::path{"."} : path, error);
  const auto resolved = fs::weakly_canonical(absolute, error);
  return error ? absolute.lexically_normal() : resolved;
}

Result<PartPath> find_part(const std::string& use, const fs::path& folder, const fs::path& root,
                           const Source& at) {
  const fs::path given{use};
  if (given.has_root_path())
    return fail(Errc::OutOfRange, at.text(), "'" + use + "' is an absolute path",
                "give the path relative to this file");
  // The shortened path is the one that is checked and opened: behind a link, '..' would lead elsewhere.
  const auto path = (folder / given).lexically_normal();
  const PartPath part{path.generic_string(), canonical_path(path)};
  const auto top = canonical_path(root);
  if (!inside(part.canonical, top))
    return fail(Errc::OutOfRange, at.text(),
                "'" + use + "' is outside the folder '" + top.filename().generic_string() + "'",
                "keep the files of an instrument inside it");
  std::error_code error;
  if (fs::exists(part.canonical, error)) return part;
  return fail(Errc::BadFile, at.text(), "there is no file '" + part.name + "'",
              suggest(part.canonical.filename().generic_string(), files_in(part.canonical.parent_path()),
                      "paths are relative to this file"));
}

}  // namespace tactus
