#include <system_error>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/load.h"

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
    names.push_back(entry->path().filename().string());
  return names;
}

}  // namespace

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
  const PartPath part{path.string(), canonical_path(path)};
  const auto top = canonical_path(root);
  if (!inside(part.canonical, top))
    return fail(Errc::OutOfRange, at.text(),
                "'" + use + "' is outside the folder '" + top.filename().string() + "'",
                "keep the files of an instrument inside it");
  std::error_code error;
  if (fs::exists(part.canonical, error)) return part;
  return fail(Errc::BadFile, at.text(), "there is no file '" + part.name + "'",
              suggest(part.canonical.filename().string(), files_in(part.canonical.parent_path()),
                      "paths are relative to this file"));
}

}  // namespace tactus
