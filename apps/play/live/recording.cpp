#include "apps/play/live/recording.h"

#include <fmt/format.h>

#include "apps/cli/take_files.h"
#include "apps/cli/version.h"

namespace tactus::app {

Recording::Recording(std::filesystem::path wav, Performer& performer, Guarded& guarded, LevelMeter& meter)
    : performer_(performer), guarded_(guarded), meter_(meter), wav_(std::move(wav)) {}

Status Recording::begin() {
  (void)end();
  auto header = take_header(performer_.instrument(), guarded_);
  header.program = version();
  performer_.describe(header);
  auto file = wav_;
  if (!files_.empty())
    file.replace_filename(
        fmt::format("{}-{}{}", wav_.stem().string(), files_.size() + 1, wav_.extension().string()));
  auto begun = TakeRecorder::start(file, std::move(header));
  if (!begun) return tl::unexpected(begun.error());
  recorder_ = std::move(*begun);
  files_.push_back(file);
  reported_dropped_ = 0;
  reported_error_ = false;
  meter_.set_next(&recorder_->tap());
  performer_.instrument().set_tap(&recorder_->tap());
  return {};
}

std::vector<std::string> Recording::end() {
  if (recorder_ == nullptr) return {};
  meter_.set_next(nullptr);
  performer_.instrument().set_tap(nullptr);
  auto words = recorder_->finish();
  recorder_.reset();
  return words;
}

void Recording::edited() {
  if (recorder_ == nullptr) return;
  TakeHeader now;
  performer_.describe(now);
  TakeEdit edit;
  edit.files = std::move(now.files);
  edit.settings = take_settings(performer_.instrument().plan());
  edit.controls = performer_.instrument().control_names();
  recorder_->note_edit(std::move(edit));
}

std::vector<std::string> Recording::news() {
  std::vector<std::string> words;
  if (recorder_ == nullptr) return words;
  const auto status = recorder_->status();
  if (!status.error.empty() && !std::exchange(reported_error_, true))
    words.push_back("recording stopped: " + status.error + "; the instrument keeps playing");
  if (status.dropped_frames > reported_dropped_)
    words.push_back(fmt::format("the disk is too slow: {} frames dropped from the recording so far",
                                status.dropped_frames));
  reported_dropped_ = status.dropped_frames;
  return words;
}

double Recording::seconds() const { return recorder_ == nullptr ? 0.0 : recorder_->status().recorded.value; }

}  // namespace tactus::app
