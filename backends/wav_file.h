#pragma once
// Thread: [control]

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"

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

/// Reads a WAV file (RIFF, WAVE_FORMAT_EXTENSIBLE or RF64) piece by piece. Any PCM or float encoding comes
/// out as double without a change of value: a 24-bit sample k is k / 2^23.
class WavReader {
 public:
  /// [control] Errors: BadFile if it is missing, no WAV file, coded with loss, or shorter than its header
  /// says.
  static Result<WavReader> open(const std::filesystem::path& path);
  ~WavReader();
  WavReader(WavReader&&) noexcept;
  WavReader& operator=(WavReader&&) noexcept;

  Hertz sample_rate() const;
  int channels() const;
  std::int64_t frames() const;
  /// [control] The next `frames` frames into channels[c][0 …]; returns how many there were, zeros follow
  /// them.
  int read(double* const* channels, int frames);

 private:
  struct File;
  explicit WavReader(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

/// Writes a WAV file piece by piece. The same samples give the same bytes: no date and no name goes in.
class WavWriter {
 public:
  /// [control] Overwrites. Errors: BadArgument for the channels or the rate; BadFile if it cannot be written.
  static Result<WavWriter> create(const std::filesystem::path& path, Hertz sample_rate, int channels,
                                  WavEncoding encoding);
  /// Closes; call `close` to learn whether that went well.
  ~WavWriter();
  WavWriter(WavWriter&&) noexcept;
  WavWriter& operator=(WavWriter&&) noexcept;

  int channels() const;
  /// [control] Errors: BadFile, for instance when the disk is full.
  [[nodiscard]] Status write(const double* const* channels, int frames);
  /// [control] Samples so far that did not fit into Pcm24.
  std::int64_t clipped() const;
  /// [control] Nothing can be written after it.
  [[nodiscard]] Status close();

 private:
  struct File;
  explicit WavWriter(std::unique_ptr<File> file);
  std::unique_ptr<File> file_;
};

/// [control] The whole file. Errors as WavReader::open.
Result<Samples> read_wav(const std::filesystem::path& path);
/// [control] Errors as WavWriter; BadArgument if the channels are not equally long.
[[nodiscard]] Status write_wav(const std::filesystem::path& path, const Samples& samples,
                               WavEncoding encoding = WavEncoding::Float32);

}  // namespace tactus
