#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/core/error.h"

namespace tactus {

/// Runs of a study that outlive the program: a folder of files *.jsonl, one line a run,
///     {"key": "9f8a…", "run": {…}}
/// with the key of what was played. A line is written in one go and flushed; one that is torn by a kill is
/// ignored, and played again. Each program that works on the same study writes a file of its own and reads
/// all.
class KeptRuns {
 public:
  /// [control] Reads what is there. `file`: name of the file that is written, such as "part_1_of_4.jsonl".
  /// Errors: BadFile.
  static Result<KeptRuns> open(const std::filesystem::path& folder, const std::string& file);
  /// Keeps nothing.
  KeptRuns() = default;

  /// [any] nullptr if it was not played yet.
  const nlohmann::ordered_json* find(std::uint64_t key) const;
  /// [any] From several threads at once. Errors: BadFile.
  Status keep(std::uint64_t key, const nlohmann::ordered_json& run);

 private:
  void read(const std::filesystem::path& file);

  std::map<std::string, nlohmann::ordered_json> runs_;
  std::filesystem::path path_;
  std::ofstream out_;
  std::unique_ptr<std::mutex> writing_ = std::make_unique<std::mutex>();
};

}  // namespace tactus
