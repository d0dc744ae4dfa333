#pragma once
// Thread: [control]

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"

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

/// One result of `tactus doctor`.
struct SystemFinding {
  enum class State { Ok, Warn, Unknown };
  State state = State::Unknown;
  std::string what;       ///< one sentence
  std::string command{};  ///< that fixes it, or that shows more; empty where there is nothing to do
  std::string name{};     ///< of what was checked
};

/// "ok", "warn", "unknown"
const char* name_of(SystemFinding::State state);

struct Process {
  std::string name;
  std::vector<std::string> arguments;
};
std::vector<Process> processes_of(const SystemFiles& system);

// Each checks one thing, without its name.

/// `tried`: a thread asked for real-time priority, or the program asked to stay in memory; `item`: "rtprio",
/// "memlock".
SystemFinding check_right(const SystemFiles& system, const Status& tried, const char* item);
SystemFinding check_governor(const SystemFiles& system);
SystemFinding check_idle(const SystemFiles& system);
SystemFinding check_kernel(const SystemFiles& system);
SystemFinding check_interrupts(const SystemFiles& system);
SystemFinding check_swap(const SystemFiles& system, bool memory_locked);
SystemFinding check_machine(const SystemFiles& system);
SystemFinding check_cards(const SystemFiles& system);
/// One for each sound card on USB, or one that says that there is none.
std::vector<SystemFinding> check_usb(const SystemFiles& system);
/// With names: one for each sound server that runs, or one that says that there is none. `pipewire`: what
/// `pw-metadata -n settings 0` prints.
std::vector<SystemFinding> check_servers(const std::vector<Process>& processes, const std::string& pipewire);

/// All of them, the most important first. `priority`, `memory`: see check_right.
std::vector<SystemFinding> check_system(const SystemFiles& system, const Status& priority,
                                        const Status& memory, const std::string& pipewire);

}  // namespace tactus::app
