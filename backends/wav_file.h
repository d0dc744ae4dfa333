#pragma once
// Thread: [control]

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"

struct sf_private_tag;  // as libsndfile calls it

namespace tactus {

/// Samples in memory, channel by channel, full scale = 1.
struct Samples {
  Hertz sample_rate = 48_kHz;
  std::vector<std::vector<double>> channels;

  std::int64_t frames() const {
    return channels.empty() ? 0 : static_cast<std::int64_t>(channels.front().size());
  }
};

/// What a WAV file holds a sample in.
enum class WavEncoding {
  Float32,  ///< exact for every float; nothing clips
  Pcm24,    ///< steps of 2^-23; clips at -1 and 1 - 2^-23
};

/// A file of libsndfile that closes itself.
using SoundFile = std::unique_ptr<sf_private_tag, int (*)(sf_private_tag*)>;

/// Reads a WAV file (RIFF, WAVE_FORMAT_EXTENSIBLE or RF64) block by block. Any PCM or float encoding comes
/// out as double without a change of value: a 24-bit sample k is k / 2^23.
class WavReader {
 public:
  /// [control] Errors: BadFile if it is missing, no WAV file, coded with loss, or shorter than its header
  /// says.
  static Result<WavReader> open(const std::filesystem::path& path);

  Hertz sample_rate() const { return sample_rate_; }
  int channels() const { return channels_; }
  std::int64_t frames() const { return frames_; }
  /// [control] The next `frames` frames into channels[c][0 …]; returns how many there were, zeros follow
  /// them.
  int read(double* const* channels, int frames);

 private:
  SoundFile sound_{nullptr, nullptr};
  Hertz sample_rate_;
  int channels_ = 0;
  std::int64_t frames_ = 0;
  std::vector<double> interleaved_;
};

/// Writes a WAV file block by block. The same samples give the same bytes: no date and no name goes in.
class WavWriter {
 public:
  /// [control] Overwrites. Errors: BadArgument for the channels or the rate; BadFile if it cannot be written.
  static Result<WavWriter> create(const std::filesystem::path& path, Hertz sample_rate, int channels,
                                  WavEncoding encoding);

  /// [control] Errors: BadFile, for instance when the disk is full.
  [[nodiscard]] Status write(const double* const* channels, int frames);
  /// [control] Nothing can be written after it. Errors: BadFile; a writer that is destroyed reports none.
  [[nodiscard]] Status close();

 private:
  std::filesystem::path path_;
  int channels_ = 0;
  WavEncoding encoding_ = WavEncoding::Float32;
  SoundFile sound_{nullptr, nullptr};
  std::vector<float> floats_;
  std::vector<int> integers_;
};

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

/// [control] The whole file. Errors as WavReader::open.
Result<Samples> read_wav(const std::filesystem::path& path);
/// [control] Errors as WavWriter; BadArgument if the channels are not equally long.
[[nodiscard]] Status write_wav(const std::filesystem::path& path, const Samples& samples,
                               WavEncoding encoding = WavEncoding::Float32);

}  // namespace tactus
