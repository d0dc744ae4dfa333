#pragma once
// Thread: [control]

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/play/live/controls/level_meter.h"
#include "apps/play/live/performer.h"
#include "backends/take/take_recorder.h"

namespace tactus::app {

/// Keeps a session as takes: take.wav, and take-2.wav and so on for each time that the device came back,
/// since a stream that begins again is another take. [control]
class Recording {
 public:
  /// All must outlive it.
  Recording(std::filesystem::path wav, Performer& performer, Guarded& guarded, LevelMeter& meter);

  /// [prepared & stopped] Ends the take that was, and begins one. Errors: of TakeRecorder::start.
  [[nodiscard]] Status begin();
  /// [stopped] What did not go well, in words.
  std::vector<std::string> end();
  /// An edit was taken over.
  void edited();
  /// What went wrong since the last look, in words; nothing most of the time.
  std::vector<std::string> news();
  /// Files that were begun, oldest first.
  const std::vector<std::filesystem::path>& files() const { return files_; }
  double seconds() const;

 private:
  Performer& performer_;
  Guarded& guarded_;
  LevelMeter& meter_;
  std::filesystem::path wav_;
  std::vector<std::filesystem::path> files_;
  std::unique_ptr<TakeRecorder> recorder_;
  std::int64_t reported_dropped_ = 0;
  bool reported_error_ = false;
};

}  // namespace tactus::app
