// What JACK plays when the program itself cannot run any more.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "backends/wav_file.h"
#include "tests/cards/jack/playing.h"
#include "tests/cards/ways.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::constant;
using test::OnServer;
using test::Playing;

namespace {

/// The server's loopback, through each library.
std::vector<std::string> loopbacks() {
  std::vector<std::string> devices = {"jack:loopback"};
  for (const auto& way : test::every_way())
    if (!way.alsa) devices.push_back(way.name + ":loopback");
  return devices;
}

}  // namespace

TEST_CASE_METHOD(OnServer, "play: a program that is killed, aborts or faults leaves zeros behind",
                 "[cards]") {
  ::setenv("ASAN_OPTIONS", "handle_segv=0", 0);  // the sanitizer would make an exit of it
  for (const auto& device : loopbacks())
    for (const int signal : {SIGKILL, SIGABRT, SIGSEGV}) {
      CAPTURE(device, signal);
      Playing play{{tone, "--device", device, "--arm"}};
      REQUIRE(play.says("delay "));
      Playing before{{tone, "--device", "jack:loopback", "--outputs", "2", "--json", "--duration", "2 s"}};
      REQUIRE(before.ends() == 0);
      CHECK(before.report()["highest_input"]["heard"] > 0.1);
      play.process().send(signal);
      CHECK(play.ends() == -signal);
      Playing after{{tone, "--device", "jack:loopback", "--outputs", "2", "--json", "--duration", "1 s"}};
      REQUIRE(after.ends() == 0);
      CHECK(after.report()["highest_input"]["heard"] == 0.0);
    }
}

TEST_CASE("play: stopped by SIGSTOP, JACK repeats its last block or plays zeros and then starts softly",
          "[cards]") {
  const auto server = test::start_sound_server({.synchronous = false});
  const test::TemporaryFolder folder;
  const auto tone = folder.write("tone.toml", constant("0.2")).string();
  const auto wav = folder.path() / "take.wav";
  const auto device = GENERATE(from_range(loopbacks()));
  CAPTURE(device);
  Playing play{{tone, "--device", device, "--arm"}};
  REQUIRE(play.says("delay "));
  Playing listener{{tone, "--device", "jack:loopback", "--outputs", "2", "--record", wav.string()}};
  REQUIRE(listener.says("delay "));
  const auto heard = [&] { return read_wav(wav)->channels.front(); };  // the drive of the listener is behind
  const auto any_from = [&](std::size_t begin, std::size_t frames, auto holds) {
    REQUIRE(test::wait_until([&] { return heard().size() >= begin + frames; }));
    const auto samples = heard();
    return std::any_of(samples.begin() + static_cast<std::ptrdiff_t>(begin), samples.end(), holds);
  };
  const auto is_full = [](double sample) { return sample > 0.1999; };
  const auto is_zero = [](double sample) { return sample == 0.0; };
  const auto is_ramp = [&](double sample) { return !is_full(sample) && !is_zero(sample); };
  REQUIRE(test::wait_until([&] { return any_from(0, 4800, is_full); }));
  play.process().pause();
  const auto paused = heard().size() + 4800;  // what was on its way
  CHECK_FALSE(any_from(paused, 48'000, is_ramp));
  play.process().send(SIGCONT);
  CHECK(test::wait_until([&] { return any_from(paused, 48'000, is_zero); }));
  CHECK(test::wait_until([&] { return any_from(paused, 48'000, is_ramp); }));
}
