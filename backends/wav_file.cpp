#include "backends/wav_file.h"

#include <fmt/format.h>
#include <sndfile.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/core/index.h"

namespace tactus {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxChannels = 1024;  // libsndfile's own limit

constexpr std::int64_t kBlock = 65536;

static_assert(std::endian::native == std::endian::little, "files have the byte order of memory");

using Tag = std::array<char, 4>;
constexpr Tag tag(const char (&text)[5]) { return {text[0], text[1], text[2], text[3]}; }

/// libsndfile reads a truncated file without an error, so the chunks are walked here.
/// Only RIFF: an RF64 file keeps its sizes elsewhere.
Status check_length(const fs::path& path) {
  std::error_code ignored;
  const auto size = static_cast<std::uint64_t>(fs::file_size(path, ignored));
  std::ifstream file{path, std::ios::binary};
  const auto read = [&](auto&... fields) {
    return (file.read(reinterpret_cast<char*>(&fields), sizeof fields) && ...);
  };
  Tag riff, wave, chunk;
  std::uint32_t bytes = 0;
  if (!read(riff, bytes, wave) || riff != tag("RIFF") || wave != tag("WAVE")) return {};
  std::uint64_t at = 12;
  while (read(chunk, bytes)) {
    at += 8;
    if (chunk == tag("data")) {
      if (at + bytes <= size) return {};
      return fail(
          Errc::BadFile, path.string(),
          fmt::format("its header announces {} bytes of samples, but the file has {}", bytes, size - at),
          "the file is truncated: copy or record it again");
    }
    at += bytes + std::uint64_t{bytes % 2};  // chunks begin at even places
    file.seekg(static_cast<std::streamoff>(at));
  }
  return fail(Errc::BadFile, path.string(), "it ends before its samples begin",
              "the file is truncated: copy or record it again");
}

bool lossless(int format) {
  constexpr std::array kLossless{SF_FORMAT_PCM_U8, SF_FORMAT_PCM_16, SF_FORMAT_PCM_24,
                                 SF_FORMAT_PCM_32, SF_FORMAT_FLOAT,  SF_FORMAT_DOUBLE};
  return std::count(kLossless.begin(), kLossless.end(), format & SF_FORMAT_SUBMASK) > 0;
}

bool is_wav(int format) {
  const int type = format & SF_FORMAT_TYPEMASK;
  return type == SF_FORMAT_WAV || type == SF_FORMAT_WAVEX || type == SF_FORMAT_RF64;
}

Status check_channels(const fs::path& path, int channels) {
  if (channels >= 1 && channels <= kMaxChannels) return {};
  return fail(Errc::BadArgument, path.string(), fmt::format("a WAV file cannot have {} channels", channels),
              fmt::format("write 1 to {}", kMaxChannels));
}

/// 24 bits in the upper part of 32, as libsndfile takes them. Not left to it, because it would scale by
/// 2^23 - 1, and a file that was read and written again would not be the same.
int to_pcm24(double sample) {
  constexpr double kSteps = 8388608.0;  // 2^23
  const double step = std::isnan(sample) ? 0.0 : std::nearbyint(sample * kSteps);
  return static_cast<int>(std::clamp(step, -kSteps, kSteps - 1.0)) * 256;
}

template <class... Fields>
std::string bytes_of(const Fields&... fields) {
  return (std::string(reinterpret_cast<const char*>(&fields), sizeof fields) + ...);
}

std::uint64_t frame_bytes(int channels) { return sizeof(float) * static_cast<std::uint64_t>(channels); }

tl::unexpected<Error> cannot_append(const fs::path& path) {
  return fail(Errc::BadFile, path.string(), why_not_written(), "check the free disk space");
}

}  // namespace

Result<WavReader> WavReader::open(const fs::path& path) {
  std::error_code ignored;
  const auto status = fs::status(path, ignored);
  if (!fs::exists(status))
    return fail(Errc::BadFile, path.string(), "there is no such file", "check the path");
  if (fs::is_directory(status))
    return fail(Errc::BadFile, path.string(), "this is a folder", "name a WAV file in it");

  SF_INFO info{};
  WavReader reader;
  reader.sound_ = {sf_open(path.string().c_str(), SFM_READ, &info), sf_close};
  if (auto length = check_length(path); !length) return tl::unexpected(length.error());
  if (!reader.sound_)
    return fail(Errc::BadFile, path.string(),
                fmt::format("it cannot be read as a WAV file ({})", sf_strerror(nullptr)),
                "give a WAV file of PCM or float samples");
  if (!is_wav(info.format))
    return fail(Errc::BadFile, path.string(), "this is a sound file, but not a WAV file",
                "convert it to WAV");
  if (!lossless(info.format))
    return fail(Errc::BadFile, path.string(), "its samples are in a lossy format",
                "save it as WAV with PCM or float samples");
  reader.sample_rate_ = Hertz{static_cast<double>(info.samplerate)};
  reader.channels_ = info.channels;
  reader.frames_ = info.frames;
  return reader;
}

int WavReader::read(double* const* channels, int frames) {
  const auto width = index(channels_);
  interleaved_.assign(width * index(frames), 0.0);
  const auto got = static_cast<int>(sf_readf_double(sound_.get(), interleaved_.data(), frames));
  for (std::size_t c = 0; c < width; ++c)
    for (int n = 0; n < frames; ++n) channels[c][n] = interleaved_[index(n) * width + c];
  return got;
}

Result<WavWriter> WavWriter::create(const fs::path& path, Hertz sample_rate, int channels,
                                    WavEncoding encoding) {
  if (auto status = check_channels(path, channels); !status) return tl::unexpected(status.error());
  if (!(sample_rate.value >= 1.0 && sample_rate.value <= std::numeric_limits<int>::max()) ||
      sample_rate.value != std::floor(sample_rate.value))
    return fail(Errc::BadArgument, path.string(),
                fmt::format("a WAV file cannot have a rate of {} Hz", sample_rate.value),
                "use a whole number of hertz");
  SF_INFO info{};
  info.samplerate = static_cast<int>(sample_rate.value);
  info.channels = channels;
  info.format = SF_FORMAT_WAV | (encoding == WavEncoding::Float32 ? SF_FORMAT_FLOAT : SF_FORMAT_PCM_24);
  WavWriter writer;
  writer.path_ = path;
  writer.channels_ = channels;
  writer.encoding_ = encoding;
  writer.sound_ = {sf_open(path.string().c_str(), SFM_WRITE, &info), sf_close};
  if (!writer.sound_)
    return fail(Errc::BadFile, path.string(), fmt::format("it cannot be written ({})", sf_strerror(nullptr)),
                "check that the folder exists and is writable");
  // The PEAK chunk carries the time of writing.
  sf_command(writer.sound_.get(), SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
  return writer;
}

Status WavWriter::write(const double* const* channels, int frames) {
  const auto width = index(channels_);
  const auto count = width * index(frames);
  const auto interleaved = [&](auto& samples, auto convert) {
    samples.resize(count);
    for (std::size_t i = 0; i < count; ++i) samples[i] = convert(channels[i % width][i / width]);
    return samples.data();
  };
  const auto to_float = [](double sample) { return static_cast<float>(sample); };
  const auto written = encoding_ == WavEncoding::Float32
                           ? sf_writef_float(sound_.get(), interleaved(floats_, to_float), frames)
                           : sf_writef_int(sound_.get(), interleaved(integers_, to_pcm24), frames);
  if (written == frames) return {};
  return fail(Errc::BadFile, path_.string(),
              fmt::format("it could not be written completely ({})", sf_strerror(sound_.get())),
              "check the free disk space");
}

Status WavWriter::close() {
  if (sf_close(sound_.release()) == 0) return {};
  return fail(Errc::BadFile, path_.string(), "it could not be closed properly", "check the free disk space");
}

std::string why_not_written() {
  const std::error_code error{errno, std::generic_category()};
  if (error == std::errc::no_space_on_device) return "the disk is full";
  return fmt::format("writing to the disk failed ({})", error ? error.message() : "unknown error");
}

std::string wav_header(Hertz sample_rate, int channels, std::int64_t frames) {
  using U16 = std::uint16_t;
  using U32 = std::uint32_t;
  constexpr std::uint64_t kBehindRiff = 86;  // bytes of the header behind the first eight
  constexpr std::uint64_t kMost32 = std::numeric_limits<U32>::max();
  const auto rate = static_cast<U32>(sample_rate.value);
  const auto frame = static_cast<U16>(frame_bytes(channels));
  const auto total = static_cast<std::uint64_t>(frames), data = frame * total, riff = kBehindRiff + data;
  const bool large = riff > kMost32;
  const auto in_32 = [&](std::uint64_t value) { return static_cast<U32>(large ? kMost32 : value); };
  const auto in_64 = [&](std::uint64_t value) { return large ? value : 0; };
  return bytes_of(tag(large ? "RF64" : "RIFF"), in_32(riff), tag("WAVE"), tag(large ? "ds64" : "JUNK"),
                  U32{28}, in_64(riff), in_64(data), in_64(total), U32{0}, tag("fmt "), U32{18}, U16{3},
                  static_cast<U16>(channels), rate, rate * frame, frame, U16{32}, U16{0}, tag("fact"), U32{4},
                  in_32(total), tag("data"), in_32(data));
}

GrowingWav::GrowingWav(fs::path path, Hertz sample_rate, int channels)
    : path_(std::move(path)),
      sample_rate_(sample_rate),
      channels_(channels),
      file_(path_, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc) {}

Result<GrowingWav> GrowingWav::create(const fs::path& path, Hertz sample_rate, int channels) {
  if (auto status = check_channels(path, channels); !status) return tl::unexpected(status.error());
  std::error_code ignored;
  if (fs::exists(path, ignored))
    return fail(Errc::BadFile, path.string(), "this take already exists",
                "choose another name, or move the file");
  GrowingWav wav{path, sample_rate, channels};
  if (wav.settle()) return wav;
  return fail(Errc::BadFile, path.string(), "it cannot be written",
              "check that the folder exists and is writable");
}

Status GrowingWav::append(const float* samples, std::int64_t frames) {
  const auto bytes = frame_bytes(channels_) * static_cast<std::uint64_t>(frames);
  if (!file_.write(reinterpret_cast<const char*>(samples), static_cast<std::streamsize>(bytes)))
    return cannot_append(path_);
  frames_ += frames;
  return {};
}

Status GrowingWav::append_silence(std::int64_t frames) {
  const std::vector<float> zeros(index(kBlock * channels_), 0.0f);
  for (; frames > 0; frames -= kBlock)
    if (auto status = append(zeros.data(), std::min(frames, kBlock)); !status) return status;
  return {};
}

// The samples first: a header must never promise what is not there.
Status GrowingWav::settle() {
  file_.flush();
  const auto header = wav_header(sample_rate_, channels_, frames_);
  file_.seekp(0).write(header.data(), static_cast<std::streamsize>(header.size())).flush();
  file_.seekp(0, std::ios::end);
  return file_ ? Status{} : cannot_append(path_);
}

void GrowingWav::save_what_is_there() {
  file_.close();
  std::error_code error;
  const auto header = wav_header(sample_rate_, channels_, 0).size();
  const auto size = fs::file_size(path_, error);
  if (error || size < header) return;
  frames_ = static_cast<std::int64_t>((size - header) / frame_bytes(channels_));
  fs::resize_file(path_, header + frame_bytes(channels_) * static_cast<std::uint64_t>(frames_), error);
  file_.clear();
  file_.open(path_, std::ios::binary | std::ios::in | std::ios::out);
  (void)settle();
}

Result<Samples> read_wav(const fs::path& path) {
  auto reader = WavReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  Samples samples{reader->sample_rate(), {}};
  samples.channels.resize(index(reader->channels()), std::vector<double>(index(reader->frames())));
  std::vector<double*> at(samples.channels.size());
  for (std::int64_t done = 0; done < reader->frames(); done += kBlock) {
    for (std::size_t c = 0; c < at.size(); ++c) at[c] = samples.channels[c].data() + done;
    reader->read(at.data(), static_cast<int>(std::min(kBlock, reader->frames() - done)));
  }
  return samples;
}

Status write_wav(const fs::path& path, const Samples& samples, WavEncoding encoding) {
  for (const auto& channel : samples.channels)
    if (static_cast<std::int64_t>(channel.size()) != samples.frames())
      return fail(Errc::BadArgument, path.string(), "its channels differ in length", "");
  auto writer =
      WavWriter::create(path, samples.sample_rate, static_cast<int>(samples.channels.size()), encoding);
  if (!writer) return tl::unexpected(writer.error());
  std::vector<const double*> at(samples.channels.size());
  for (std::int64_t done = 0; done < samples.frames(); done += kBlock) {
    for (std::size_t c = 0; c < at.size(); ++c) at[c] = samples.channels[c].data() + done;
    if (auto status = writer->write(at.data(), static_cast<int>(std::min(kBlock, samples.frames() - done)));
        !status)
      return status;
  }
  return writer->close();
}

}  // namespace tactus
