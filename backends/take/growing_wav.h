#pragma once
// Thread: [control]

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "engine/core/error.h"
#include "engine/core/units.h"

namespace tactus {

/// The bytes before the samples of a WAV file of float32, little-endian:
///   RIFF, JUNK of 28 bytes, fmt (format 3, IEEE float), fact, data
/// and beyond 4 GiB, in the same place and of the same length (EBU Tech 3306, "RF64", 2009, section 3.5):
///   RF64, ds64 (the sizes in 64 bits), fmt, fact, data
/// so that a file can turn from one into the other while it grows.
std::string wav_header(Hertz sample_rate, int channels, std::int64_t frames);

/// [control] Why the last write failed: "the disk is full".
std::string why_not_written();

/// A WAV file that any program can open at any time while it is written, and after the writer was killed:
/// `settle` updates the header. libsndfile turns RF64 into RIFF only when it closes a file,
/// so that one that was cut would be RF64, which fewer programs read.
class GrowingWav {
 public:
  /// [control] Errors: BadFile if it exists already or cannot be written; BadArgument for the channels.
  static Result<GrowingWav> create(const std::filesystem::path& path, Hertz sample_rate, int channels);

  /// [control] Frame by frame. Errors: BadFile; then the file is to be closed.
  [[nodiscard]] Status append(const float* samples, std::int64_t frames);
  [[nodiscard]] Status append_silence(std::int64_t frames);
  /// [control] Everything so far goes to the system, then the header. Errors: BadFile.
  [[nodiscard]] Status settle();
  /// [control] After an error: what reached the disk is kept, to the last whole frame.
  void save_what_is_there();

  std::int64_t frames() const { return frames_; }

 private:
  GrowingWav(std::filesystem::path path, Hertz sample_rate, int channels);

  std::filesystem::path path_;
  Hertz sample_rate_;
  int channels_;
  std::fstream file_;
  std::int64_t frames_ = 0;
};

}  // namespace tactus
