#pragma once
// Thread: [control]

#include <filesystem>
#include <map>
#include <vector>

namespace tactus::app {

/// Tells when one of some files was written to. It looks at times and sizes, so it works everywhere.
class WatchedFiles {
 public:
  /// [control] From now on these.
  void watch(const std::vector<std::filesystem::path>& files);
  /// [control] Was any of them changed, taken away or brought back since the last call?
  bool changed();

 private:
  struct Look {
    std::filesystem::file_time_type time{};
    std::uintmax_t bytes = 0;
    bool operator==(const Look&) const = default;
  };
  static Look look_at(const std::filesystem::path& file);
  std::map<std::filesystem::path, Look> files_;
};

}  // namespace tactus::app
