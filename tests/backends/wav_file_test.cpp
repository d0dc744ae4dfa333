#include "backends/wav_file.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/support/error_summary.h"

using namespace tactus;
namespace fs = std::filesystem;

namespace {

/// A folder of its own that goes with the test.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("tactus_wav_" + std::to_string(std::random_device{}()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// Numbers that are exact in float32.
Samples noise(std::size_t channels, std::size_t frames) {
  std::mt19937 random{7};
  std::uniform_real_distribution<float> uniform{-1.0f, 1.0f};
  Samples samples{Hertz{44100.0}, {}};
  samples.channels.assign(channels, std::vector<double>(frames));
  for (auto& channel : samples.channels)
    for (auto& sample : channel) sample = static_cast<double>(uniform(random));
  return samples;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file{path, std::ios::binary};
  return {std::istreambuf_iterator<char>{file}, {}};
}

void put(const fs::path& path, const std::string& bytes) {
  std::ofstream{path, std::ios::binary}.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::string names_of(const fs::path& path) {
  const auto samples = read_wav(path);
  REQUIRE_FALSE(samples.has_value());
  CHECK(samples.error().code == Errc::BadFile);
  CHECK(samples.error().where == path.string());
  return test::names_in(samples.error().what);
}

}  // namespace

TEST_CASE("wav_file: float32 comes back exactly, with rate and channels", "[backends]") {
  const Folder folder;
  // More frames than one piece of 65536, so that blocks must fit together.
  const auto samples = noise(3, 70'000);
  REQUIRE(write_wav(folder / "a.wav", samples));
  const auto back = read_wav(folder / "a.wav");
  REQUIRE(back);
  CHECK(back->sample_rate == samples.sample_rate);
  CHECK((back->channels == samples.channels));
}

TEST_CASE("wav_file: float32 keeps what lies beyond full scale", "[backends]") {
  const Folder folder;
  const Samples samples{48_kHz, {{-2.5, 1.0, 1000.0, 0x1p-140}}};
  REQUIRE(write_wav(folder / "a.wav", samples));
  CHECK((read_wav(folder / "a.wav")->channels == samples.channels));
}

TEST_CASE("wav_file: 24 bits come back to half a step, and whole steps exactly", "[backends]") {
  const Folder folder;
  auto samples = noise(2, 5000);
  samples.channels[0][0] = 0x1p-23;
  samples.channels[0][1] = -1.0;
  samples.channels[0][2] = 1.0 - 0x1p-23;
  samples.channels[0][3] = 0.5;
  REQUIRE(write_wav(folder / "a.wav", samples, WavEncoding::Pcm24));
  const auto once = read_wav(folder / "a.wav");
  REQUIRE(once);
  for (std::size_t n = 0; n < 4; ++n) CHECK(once->channels[0][n] == samples.channels[0][n]);
  double worst = 0;
  for (std::size_t c = 0; c < 2; ++c)
    for (std::size_t n = 0; n < 5000; ++n)
      worst = std::max(worst, std::abs(once->channels[c][n] - samples.channels[c][n]));
  CHECK(worst <= 0x1p-24);
  CHECK(worst > 0.0);

  REQUIRE(write_wav(folder / "b.wav", *once, WavEncoding::Pcm24));
  CHECK(bytes_of(folder / "a.wav") == bytes_of(folder / "b.wav"));
}

TEST_CASE("wav_file: 24 bits clip at full scale", "[backends]") {
  const Folder folder;
  auto writer = WavWriter::create(folder / "a.wav", 48_kHz, 1, WavEncoding::Pcm24);
  REQUIRE(writer);
  const std::vector<double> samples = {1.0, -1.0, 1.5, -1.5, 0.0};
  const double* channel = samples.data();
  REQUIRE(writer->write(&channel, 5));
  REQUIRE(writer->close());
  const double top = 1.0 - 0x1p-23;  // 1.0 is one step too high, -1.0 just fits
  CHECK(read_wav(folder / "a.wav")->channels[0] == std::vector<double>{top, -1.0, top, -1.0, 0.0});
}

TEST_CASE("wav_file: reading past the end gives zeros and says how much there was", "[backends]") {
  const Folder folder;
  REQUIRE(write_wav(folder / "a.wav", {48_kHz, {{0.25, 0.5, 0.75}}}));
  auto reader = WavReader::open(folder / "a.wav");
  REQUIRE(reader);
  CHECK(reader->frames() == 3);
  std::vector<double> block(4, 9.0);
  double* channel = block.data();
  CHECK(reader->read(&channel, 2) == 2);
  CHECK(reader->read(&channel, 4) == 1);
  CHECK(block == std::vector<double>{0.75, 0.0, 0.0, 0.0});
}

TEST_CASE("wav_file: the same samples give the same bytes", "[backends]") {
  const Folder folder;
  const auto encoding = GENERATE(WavEncoding::Float32, WavEncoding::Pcm24);
  REQUIRE(write_wav(folder / "a.wav", noise(2, 100), encoding));
  REQUIRE(write_wav(folder / "b.wav", noise(2, 100), encoding));
  CHECK(bytes_of(folder / "a.wav") == bytes_of(folder / "b.wav"));
  // A chunk with the time of writing would differ a second later.
  CHECK(bytes_of(folder / "a.wav").find("PEAK") == std::string::npos);
}

TEST_CASE("wav_file: what cannot be read is said in words", "[backends]") {
  const Folder folder;
  CHECK(names_of(folder / "none.wav").empty());
  fs::create_directory(folder / "folder");
  CHECK(names_of(folder / "folder").empty());
  put(folder / "text.wav", "This is a letter and not a sound.\n");
  CHECK(names_of(folder / "text.wav").empty());
  put(folder / "empty.wav", "");
  CHECK(names_of(folder / "empty.wav").empty());
}

TEST_CASE("wav_file: a header that lies is found out", "[backends]") {
  const Folder folder;
  REQUIRE(write_wav(folder / "whole.wav", noise(2, 100), WavEncoding::Pcm24));
  const auto bytes = bytes_of(folder / "whole.wav");

  // 100 frames of 2 channels of 3 bytes are 600 bytes; the last 90 are cut off.
  put(folder / "cut.wav", bytes.substr(0, bytes.size() - 90));
  CHECK(names_of(folder / "cut.wav") == "600 510");
  put(folder / "head.wav", bytes.substr(0, 30));
  CHECK(names_of(folder / "head.wav").empty());

  auto none = bytes;
  none[22] = none[23] = '\0';  // the channel count in the format chunk
  put(folder / "zero.wav", none);
  CHECK(names_of(folder / "zero.wav").empty());
}

TEST_CASE("wav_file: a lossy encoding is refused", "[backends]") {
  const Folder folder;
  // Format tag 7: mu-law, one byte a sample.
  const std::string head{
      "RIFF\x2c\0\0\0WAVEfmt \x10\0\0\0\x07\0\x01\0\x40\x1f\0\0\x40\x1f\0\0\x01\0\x08\0"
      "data\x08\0\0\0",
      44};
  put(folder / "law.wav", head + "01234567");
  CHECK(names_of(folder / "law.wav").empty());
}

TEST_CASE("wav_file: what cannot be written is said in words", "[backends]") {
  const Folder folder;
  CHECK(test::summary(write_wav(folder / "a.wav", {48_kHz, {}}).error().at("")) == "BadArgument 0 1 1024");
  CHECK(test::summary(write_wav(folder / "a.wav", {Hertz{0.5}, {{0.0}}}).error().at("")) ==
        "BadArgument 0.5");
  CHECK(test::summary(write_wav(folder / "a.wav", {48_kHz, {{0.0}, {0.0, 1.0}}}).error().at("")) ==
        "BadArgument");
  const auto lost = write_wav(folder / "no" / "such" / "a.wav", {48_kHz, {{0.0}}});
  REQUIRE_FALSE(lost);
  CHECK(lost.error().code == Errc::BadFile);
}
