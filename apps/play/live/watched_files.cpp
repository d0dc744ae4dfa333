#include "apps/play/live/watched_files.h"

namespace tactus::app {

WatchedFiles::Look WatchedFiles::look_at(const std::filesystem::path& file) {
  std::error_code missing;
  Look look{std::filesystem::last_write_time(file, missing), 0};
  if (missing) return {};
  look.bytes = std::filesystem::file_size(file, missing);
  return missing ? Look{} : look;
}

void WatchedFiles::watch(const std::vector<std::filesystem::path>& files) {
  std::map<std::filesystem::path, Look> now;
  for (const auto& file : files) {
    const auto known = files_.find(file);
    now.emplace(file, known == files_.end() ? look_at(file) : known->second);
  }
  files_ = std::move(now);
}

bool WatchedFiles::changed() {
  bool any = false;
  for (auto& [file, before] : files_) {
    const auto now = look_at(file);
    any = any || !(now == before);
    before = now;
  }
  return any;
}

}  // namespace tactus::app
