#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// Results of runs that outlive the program: a folder of files *.jsonl, one line per run,
///     {"key": "9f8a…", "run": [0.5, null, …]}
/// with the key of the scene that was played; null is a non-finite number. A line is written at once and
/// flushed; an incomplete last line is ignored, and its run is played again. Each program that works on the
/// same sweep writes a file of its own and reads all.
class RunCache {
 public:
  /// [control] Reads the files of the folder. `file`: name of the file that is written, such as
  /// "part_1_of_4.jsonl". Errors: BadFile.
  static Result<RunCache> open(const std::filesystem::path& folder, const std::string& file);
  /// [control] Stores nothing.
  RunCache() = default;

  /// [any] Nothing if it was not played yet.
  std::optional<std::vector<double>> find(std::uint64_t key) const;
  /// [any] From several threads at once. Errors: BadFile.
  Status keep(std::uint64_t key, const std::vector<double>& run);

 private:
  void read(const std::filesystem::path& file);

  std::map<std::string, std::vector<double>> runs_;
  std::filesystem::path path_;
  std::ofstream out_;
  std::unique_ptr<std::mutex> writing_ = std::make_unique<std::mutex>();
};

}  // namespace tactus
