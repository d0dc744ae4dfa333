#pragma once
// Thread: [control] unless stated otherwise

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "apps/play/live/performer.h"

namespace tactus::app {

/// Detects when one of some files was written to, by its time and size, so it works everywhere.
class WatchedFiles {
 public:
  using Stamp = std::pair<std::filesystem::file_time_type, std::uintmax_t>;  ///< of a missing file: zeros
  using StampOf = std::function<Stamp(const std::filesystem::path&)>;

  explicit WatchedFiles(StampOf stamp_of = read_stamp) : stamp_of_(std::move(stamp_of)) {}

  /// From now on these.
  void watch(const std::vector<std::filesystem::path>& files);
  /// Was any of them changed, removed or created since the last call?
  bool changed();

  static Stamp read_stamp(const std::filesystem::path& file);

 private:
  StampOf stamp_of_;
  std::map<std::filesystem::path, Stamp> files_;
};

/// Watches the files of a performer and reads them again, on a thread of its own: a file system that does not
/// answer holds up no one else, except its destruction.
class EditReader {
 public:
  /// `read`: on the thread, when one of `files` was changed; then it watches those that were read.
  EditReader(WatchedFiles files, std::function<Edit()> read);
  ~EditReader();
  EditReader(const EditReader&) = delete;
  EditReader& operator=(const EditReader&) = delete;

  /// An edit that was read, each once. The next one is read when this one was taken.
  std::optional<Edit> take();

 private:
  void run();
  std::optional<Edit> look_again(bool may_read);
  std::optional<Edit> look(bool may_read);

  // Of the thread.
  WatchedFiles files_;
  const std::function<Edit()> read_;
  bool changed_ = false;

  std::mutex mutex_;  ///< never held while a file is read
  std::condition_variable wake_;
  bool done_ = false;
  std::optional<Edit> edit_;
  std::thread thread_;
};

}  // namespace tactus::app
