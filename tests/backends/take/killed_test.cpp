#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "backends/take/take.h"
#include "backends/wav_file.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::test;

namespace {

/// Frames that had gone by when a recording was killed, at least `frames`.
std::int64_t record_and_kill(const std::filesystem::path& wav, std::int64_t frames) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const auto child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    execl(TACTUS_RECORD_FOR_EVER, "record_for_ever", wav.c_str(), nullptr);
    std::_Exit(1);
  }
  close(ends[1]);
  std::int64_t done = 0, reported = 0;
  const auto next = [&] {
    return read(ends[0], &reported, sizeof reported) == static_cast<ssize_t>(sizeof reported);
  };
  while (done < frames && next()) done = reported;
  kill(child, SIGKILL);
  while (next()) done = reported;
  waitpid(child, nullptr, 0);
  close(ends[0]);
  return done;
}

/// Frames that a killed recording lost.
std::int64_t lost_when_killed_after(std::int64_t frames) {
  const TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav";
  const auto played = record_and_kill(wav, frames);
  REQUIRE(played >= frames);
  const auto take = read_take(wav);
  REQUIRE(take.has_value());
  CHECK_FALSE(take->finished);
  CHECK(why_not_exact(*take).empty());
  auto samples = read_wav(wav);
  REQUIRE(samples.has_value());
  CHECK(samples->channels.size() == 2);
  const auto whole = std::min(samples->frames(), take->complete);
  // Entry by entry beside the sample that it was made from: both files are whole up to there.
  REQUIRE(static_cast<std::int64_t>(take->engine.size()) >= whole / 64);
  for (std::int64_t block = 0; block < whole / 64; ++block)
    REQUIRE(take->engine[static_cast<std::size_t>(block)].value ==
            samples->channels[0][static_cast<std::size_t>(64 * block)]);
  return played - whole;
}

}  // namespace

TEST_CASE("takes: kill -9 loses at most a second, and any program opens what is there", "[take]") {
  CHECK(lost_when_killed_after(60000) <= 48000);
}

TEST_CASE("takes: so do 50 times, early and late", "[.large]") {
  std::int64_t worst = 0;
  for (int n = 0; n < 50; ++n) worst = std::max(worst, lost_when_killed_after(20000 + 1009 * n));
  std::cout << "killed 50 times: at most " << static_cast<double>(worst) / 48000 << " s lost\n";
  CHECK(worst <= 48000);
}
