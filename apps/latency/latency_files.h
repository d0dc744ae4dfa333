#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/core/error.h"
#include "latency/calibration.h"

namespace tactus::app {

/// Files that somebody recorded.
struct CaptureFiles {
  std::string capture;
  std::string probe;           ///< what was played; empty: it is the first channel of `capture`
  std::optional<int> channel;  ///< of `capture`, from 1; left out: the first that was captured
  std::optional<Hertz> rate;   ///< of both, where their headers are wrong
};

struct Capture {
  LoopRecording recording;
  int channel = 0;   ///< of `recording.captured`, from 0
  std::string note;  ///< a message for the user, or empty
};

/// [control] Both as one recording, as if they had begun together: a probe of another rate is resampled.
/// Errors: BadFile for what a file holds; BadArgument, at "--…", for what was asked of it.
Result<Capture> read_capture(const CaptureFiles& files);

/// [control] As float32: channel 1 is what was played, then all that was captured. `read_capture` without a
/// probe reads it back. Errors: BadFile.
Status write_recording(const std::string& path, const LoopRecording& recording);

/// [control] The profile as a graph that scenes can use (engine/scene/file/path_file.h), with what was
/// measured, on which device. Errors: BadFile.
Status write_profile(const std::filesystem::path& file, const Calibration& calibration,
                     const std::string& device);
/// [control] The profile of such a file at `sample_rate`, whatever it was measured at. Errors: the first of
/// the file.
Result<PathProfile> read_profile(const std::filesystem::path& file, Hertz sample_rate);

}  // namespace tactus::app
