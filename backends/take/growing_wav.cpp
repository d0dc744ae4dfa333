#include "backends/take/growing_wav.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/core/index.h"

namespace tactus {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are written in the byte order of memory");

constexpr std::uint64_t kMost32 = std::numeric_limits<std::uint32_t>::max();
constexpr int kMaxChannels = 1024;

class Bytes {
 public:
  Bytes& tag(const char* name) { return text_.append(name, 4), *this; }
  Bytes& number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) text_ += static_cast<char>(value >> (8 * i) & 0xff);
    return *this;
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::uint64_t frame_bytes(int channels) { return sizeof(float) * static_cast<std::uint64_t>(channels); }

tl::unexpected<Error> cannot_write(const std::filesystem::path& path) {
  return fail(Errc::BadFile, path.string(), why_not_written(), "check the free disk space");
}

}  // namespace

std::string why_not_written() {
  const std::error_code error{errno, std::generic_category()};
  if (error == std::errc::no_space_on_device) return "the disk is full";
  return fmt::format("writing to the disk failed ({})", error ? error.message() : "unknown error");
}

std::string wav_header(Hertz sample_rate, int channels, std::int64_t frames) {
  constexpr std::uint64_t kBehindRiff = 86;  // bytes of the header behind the first eight
  const auto rate = static_cast<std::uint64_t>(sample_rate.value);
  const auto data = frame_bytes(channels) * static_cast<std::uint64_t>(frames);
  const auto riff = kBehindRiff + data;
  const bool large = riff > kMost32;
  const auto in_32 = [&](std::uint64_t value) { return large ? kMost32 : value; };
  Bytes bytes;
  bytes.tag(large ? "RF64" : "RIFF").number(in_32(riff), 4).tag("WAVE");
  bytes.tag(large ? "ds64" : "JUNK").number(28, 4);
  bytes.number(large ? riff : 0, 8).number(large ? data : 0, 8);
  bytes.number(large ? static_cast<std::uint64_t>(frames) : 0, 8).number(0, 4);
  bytes.tag("fmt ").number(18, 4).number(3, 2).number(static_cast<std::uint64_t>(channels), 2);
  bytes.number(rate, 4).number(rate * frame_bytes(channels), 4);
  bytes.number(frame_bytes(channels), 2).number(32, 2).number(0, 2);
  bytes.tag("fact").number(4, 4).number(in_32(static_cast<std::uint64_t>(frames)), 4);
  bytes.tag("data").number(in_32(data), 4);
  return bytes.take();
}

GrowingWav::GrowingWav(std::filesystem::path path, Hertz sample_rate, int channels)
    : path_(std::move(path)),
      sample_rate_(sample_rate),
      channels_(channels),
      file_(path_, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc) {}

Result<GrowingWav> GrowingWav::create(const std::filesystem::path& path, Hertz sample_rate, int channels) {
  if (channels < 1 || channels > kMaxChannels)
    return fail(Errc::BadArgument, path.string(), fmt::format("a WAV file cannot have {} channels", channels),
                fmt::format("record 1 to {}", kMaxChannels));
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored))
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
    return cannot_write(path_);
  frames_ += frames;
  return {};
}

Status GrowingWav::append_silence(std::int64_t frames) {
  constexpr std::int64_t kBlock = 4096;
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
  return file_ ? Status{} : cannot_write(path_);
}

void GrowingWav::save_what_is_there() {
  file_.close();
  std::error_code error;
  const auto header = wav_header(sample_rate_, channels_, 0).size();
  const auto size = std::filesystem::file_size(path_, error);
  if (error || size < header) return;
  frames_ = static_cast<std::int64_t>((size - header) / frame_bytes(channels_));
  std::filesystem::resize_file(path_, header + frame_bytes(channels_) * static_cast<std::uint64_t>(frames_),
                               error);
  file_.clear();
  file_.open(path_, std::ios::binary | std::ios::in | std::ios::out);
  (void)settle();
}

}  // namespace tactus
