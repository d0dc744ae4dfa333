#pragma once
// Thread: [control]

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// The files of an operating system below `root`: "/", or a folder of a test. Nothing needs to be root.
class SystemFiles {
 public:
  explicit SystemFiles(std::filesystem::path root = "/") : root_(std::move(root)) {}

  bool exists(const std::string& path) const {
    std::error_code ignored;
    return std::filesystem::exists(root_ / path, ignored);
  }
  /// Nothing if it cannot be read.
  std::optional<std::string> text(const std::string& path) const {
    std::ifstream in{root_ / path, std::ios::binary};
    if (!in) return std::nullopt;
    std::string text(kMaxBytes, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (in.bad()) return std::nullopt;
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
  }
  /// The first line; empty if it cannot be read.
  std::string line(const std::string& path) const {
    auto first = text(path).value_or("");
    first.resize(std::min(first.size(), first.find('\n')));
    return first;
  }
  /// Names in a folder, sorted.
  std::vector<std::string> names(const std::string& folder) const {
    namespace fs = std::filesystem;
    std::error_code error;
    std::vector<std::string> all;
    for (fs::directory_iterator entry{root_ / folder, error}, end; !error && entry != end;
         entry.increment(error))
      all.push_back(entry->path().filename().string());
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  // Files of /proc have no size: they are read to their end. Some have no end.
  static constexpr std::size_t kMaxBytes = 1 << 20;
  std::filesystem::path root_;
};

/// A system as it can be read, and what it granted.
struct SystemState : SystemFiles {
  using SystemFiles::SystemFiles;
  Status priority, memory;  ///< a thread asked for real-time priority; the program asked to stay in memory
  std::string pipewire;     ///< what `pw-metadata -n settings 0` prints
};

/// One result of `tactus doctor`.
struct SystemFinding {
  enum class State { Ok, Warn, Unknown };
  State state = State::Unknown;
  std::string what;       ///< one sentence
  std::string command{};  ///< that fixes it, or that shows more; empty where there is nothing to do
  std::string name{};     ///< of what was checked
};

/// All findings, the most important first. Each sound server that runs and each sound card on USB has its
/// own.
std::vector<SystemFinding> check_system(const SystemState& system);

/// Of each connected output of a rig: can it hold a constant force?
std::vector<SystemFinding> check_rig_outputs(const Rig& rig, const std::string& file);

}  // namespace tactus::app
