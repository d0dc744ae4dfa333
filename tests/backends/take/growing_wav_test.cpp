#include <catch2/catch.hpp>
#include <fstream>
#include <iostream>
#include <numeric>

#include "backends/wav_file.h"
#include "tests/support/error_summary.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::test;

namespace {

std::uint64_t number_at(const std::string& bytes, std::size_t at, int count) {
  std::uint64_t value = 0;
  for (int i = count - 1; i >= 0; --i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
  return value;
}

}  // namespace

TEST_CASE("growing wav: opens with all that is settled, while it is still written", "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.wav";
  auto wav = GrowingWav::create(path, 96_kHz, 3);
  REQUIRE(wav.has_value());
  CHECK(read_wav(path)->frames() == 0);
  const std::vector<float> frames{0.1f, -0.2f, 0.3f, 1e-40f, 1e30f, -0.0f};
  REQUIRE(wav->append(frames.data(), 2));
  REQUIRE(wav->settle());
  REQUIRE(wav->append(frames.data(), 1));
  const auto there = read_wav(path);
  REQUIRE(there.has_value());
  CHECK(there->sample_rate == 96_kHz);
  REQUIRE(there->channels.size() == 3);
  REQUIRE(there->frames() == 2);
  for (std::size_t i = 0; i < frames.size(); ++i)
    CHECK(static_cast<float>(there->channels[i % 3][i / 3]) == frames[i]);
}

// EBU Tech 3306: sizes that do not fit into 32 bits are all ones and stand in ds64.
TEST_CASE("growing wav: the header turns from RIFF to RF64 at 4 GiB and keeps its length", "[take]") {
  const std::int64_t last = (0xffffffffLL - 86) / 4;
  const auto riff = wav_header(48_kHz, 1, last), rf64 = wav_header(48_kHz, 1, last + 1);
  CHECK(riff.size() == 94);
  CHECK(rf64.size() == riff.size());
  CHECK(riff.substr(0, 4) == "RIFF");
  CHECK(riff.substr(12, 4) == "JUNK");
  CHECK(number_at(riff, 4, 4) == static_cast<std::uint64_t>(86 + 4 * last));
  CHECK(number_at(riff, 90, 4) == static_cast<std::uint64_t>(4 * last));
  CHECK(rf64.substr(0, 4) == "RF64");
  CHECK(rf64.substr(12, 4) == "ds64");
  CHECK(number_at(rf64, 4, 4) == 0xffffffff);
  CHECK(number_at(rf64, 20, 8) == static_cast<std::uint64_t>(86 + 4 * (last + 1)));
  CHECK(number_at(rf64, 28, 8) == static_cast<std::uint64_t>(4 * (last + 1)));
  CHECK(number_at(rf64, 36, 8) == static_cast<std::uint64_t>(last + 1));
  CHECK(number_at(rf64, 90, 4) == 0xffffffff);
}

TEST_CASE("growing wav: a file of 5 GiB opens, with all its frames", "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "large.wav";
  const std::int64_t frames = (5LL << 30) / 8;
  folder.write("large.wav", wav_header(48_kHz, 2, frames));
  std::filesystem::resize_file(path, 94 + 8 * static_cast<std::uintmax_t>(frames));  // sparse
  const auto reader = WavReader::open(path);
  REQUIRE(reader.has_value());
  CHECK(reader->frames() == frames);
  CHECK(reader->channels() == 2);
}

TEST_CASE("growing wav: 4.5 GiB written piece by piece open, and the last frame is the last", "[.large]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "large.wav";
  constexpr int kPiece = 1 << 16;
  std::vector<float> piece(2 * kPiece);
  auto wav = GrowingWav::create(path, 48_kHz, 2);
  REQUIRE(wav.has_value());
  const std::int64_t frames = (9LL << 29) / 8 / kPiece * kPiece;
  for (std::int64_t n = 0; n < frames; n += kPiece) {
    std::iota(piece.begin(), piece.end(), static_cast<float>(n % 8388608));
    REQUIRE(wav->append(piece.data(), kPiece));
    REQUIRE(wav->settle());
  }
  auto reader = WavReader::open(path);
  REQUIRE(reader.has_value());
  REQUIRE(reader->frames() == frames);
  std::vector<double> left(kPiece), right(kPiece);
  const std::vector<double*> to{left.data(), right.data()};
  for (std::int64_t n = 0; n < frames; n += kPiece) {
    REQUIRE(reader->read(to.data(), kPiece) == kPiece);
    REQUIRE(left[0] == static_cast<double>(n % 8388608));
    REQUIRE(right[kPiece - 1] == static_cast<double>(static_cast<float>(n % 8388608 + 2 * kPiece - 1)));
  }
  std::cout << "RF64: " << std::filesystem::file_size(path) << " bytes, " << frames << " frames read back\n";
}

TEST_CASE("growing wav: what is there is not overwritten", "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.write("a.wav", "precious");
  const auto wav = GrowingWav::create(path, 48_kHz, 1);
  REQUIRE_FALSE(wav.has_value());
  CHECK(folder.strip(test::summary(wav)) == "a.wav BadFile");
  CHECK(std::filesystem::file_size(path) == 8);
  const auto nowhere = GrowingWav::create(folder.path() / "none" / "a.wav", 48_kHz, 1);
  REQUIRE_FALSE(nowhere.has_value());
  CHECK(folder.strip(test::summary(nowhere)) == "none/a.wav BadFile");
}
