#include "apps/cli/take_files.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "backends/wav_file.h"
#include "tests/support/desk.h"
#include "tests/support/error_summary.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
namespace fs = std::filesystem;

namespace {

/// What a take from a stranger does whose graph plays `sound`, which lay in `root`.
std::string unpacked(const fs::path& root, const std::string& sound, const std::string& print = "00") {
  const test::TemporaryFolder folder;
  TakeFiles files{"main.toml", {{"main.toml", "format = 1\n"}}, {{sound, print}}, root.string()};
  return test::summary(app::unpack(files, folder.path()));
}

}  // namespace

TEST_CASE("take files: a sound of a take is a regular file of a size that can be read", "[take]") {
  const test::TemporaryFolder folder;
  const auto place = [&](const std::string& name) { return (folder.path() / name).string(); };
  CHECK(unpacked(folder.path(), "none.wav") == place("none.wav") + " BadFile");
  folder.write("huge.wav", "");
  fs::resize_file(folder.path() / "huge.wav", (std::uintmax_t{1} << 30) + 1);  // sparse
  CHECK(unpacked(folder.path(), "huge.wav") == place("huge.wav") + " BadFile 1");
  CHECK(unpacked(folder.path(), ".") == place(".") + " BadFile 1");
  CHECK(unpacked("/dev", "zero") == "/dev/zero BadFile 1");
  CHECK(unpacked("/dev", "zero", "") == "/dev/zero BadFile 1");
  REQUIRE(mkfifo(place("pipe").c_str(), 0600) == 0);
  CHECK(unpacked(folder.path(), "pipe") == place("pipe") + " BadFile 1");
}

TEST_CASE("take files: hostile takes are refused in words, with exit code 3", "[take]") {
  const test::Desk desk;
  TakeHeader header;
  header.inputs = {"in"};
  header.outputs = {"out"};
  header.files = {"main.toml",
                  {{"main.toml", "format = 1\n[inputs]\nin = {}\n[outputs]\nout = { from = \"in\" }\n"}},
                  {},
                  "/dev"};
  header.guard = {GuardedChannel{}};
  header.input_scales = {2.0};
  Take take;
  take.complete = 10;
  take.finished = true;
  REQUIRE(write_wav(desk.file("take.wav"), {48_kHz, {std::vector<double>(10), std::vector<double>(10)}}));
  const auto replay = [&](const TakeHeader& changed) {
    desk.folder.write("take.jsonl", journal_line(changed) + journal_line(take));
    return desk.run("render --replay take.wav");
  };
  CHECK(replay(header).exit == 0);
  auto padded = header;
  for (const int padding : {-1, 480'001, 2'000'000'000}) {
    padded.padding_frames = padding;
    test::check_exit(replay(padded), 3, "take.jsonl:1 'padding_frames' 480000");
  }
  auto device = header;
  device.files.sounds = {{"zero", "00"}};
  test::check_exit(replay(device), 3, "/dev/zero");
  fs::remove(desk.file("take.jsonl"));
  REQUIRE(mkfifo(desk.file("take.jsonl").c_str(), 0600) == 0);
  test::check_exit(desk.run("render --replay take.wav"), 3, "take.jsonl");
}
