#pragma once
// Thread: [control]

#include <filesystem>
#include <map>
#include <utility>
#include <vector>

namespace tactus::app {

/// Detects when one of some files was written to, by its time and size, so it works everywhere.
class WatchedFiles {
 public:
  /// From now on these.
  void watch(const std::vector<std::filesystem::path>& files) {
    std::map<std::filesystem::path, Stamp> watched;
    for (const auto& file : files)
      watched.emplace(file, files_.contains(file) ? files_[file] : stamp_of(file));
    files_ = std::move(watched);
  }
  /// Was any of them changed, removed or created since the last call?
  bool changed() {
    bool any = false;
    for (auto& [file, before] : files_) any = std::exchange(before, stamp_of(file)) != before || any;
    return any;
  }

 private:
  using Stamp = std::pair<std::filesystem::file_time_type, std::uintmax_t>;  ///< of a missing file: zeros

  static Stamp stamp_of(const std::filesystem::path& file) {
    std::error_code missing;
    const auto time = std::filesystem::last_write_time(file, missing);
    const auto bytes = missing ? 0 : std::filesystem::file_size(file, missing);
    return missing ? Stamp{} : Stamp{time, bytes};
  }
  std::map<std::filesystem::path, Stamp> files_;
};

}  // namespace tactus::app
