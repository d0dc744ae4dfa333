// What JACK plays when the program itself cannot run any more.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "backends/wav_file.h"
#include "engine/guard/drive_limits.h"
#include "tests/cards/jack/playing.h"
#include "tests/cards/ways.h"
#include "tests/support/undisturbed.h"

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
                 "[cards][slow]") {
  ::setenv("ASAN_OPTIONS", "handle_segv=0", 0);  // the sanitizer would make an exit of it
  for (const auto& device : loopbacks())
    for (const int signal : {SIGKILL, SIGABRT, SIGSEGV}) {
      CAPTURE(device, signal);
      Playing play{{tone, "--device", device, "--arm", "--shared-port"}};
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
          "[cards][slow]") {
  const auto server = test::start_sound_server({.synchronous = false});
  const test::TemporaryFolder folder;
  const auto tone = folder.write("tone.toml", constant("0.2")).string();
  const auto wav = folder.path() / "take.wav";
  const auto device = GENERATE(from_range(loopbacks()));
  CAPTURE(device);
  Playing play{{tone, "--device", device, "--arm", "--shared-port"}};
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

TEST_CASE_METHOD(OnServer, "play: where the input device goes the output fades within its slew limit",
                 "[cards][slow]") {
  const auto wav = folder.path() / "take.wav";
  auto input = std::make_unique<test::DelayClient>(test::DelayClient::Settings{.name = "input"});
  const auto louder = folder.write("louder.toml", constant("0.4")).string();
  Playing play{{louder, "--device", "jack:loopback", "--input-device", "jack:" + input->name(), "--arm"}};
  REQUIRE(play.says("delay "));
  Playing listener{{tone, "--device", "jack:loopback", "--outputs", "2", "--record", wav.string()}};
  REQUIRE(listener.says("delay "));
  const auto heard = [&] { return read_wav(wav)->channels.front(); };
  const auto is = [&](double level) {
    return test::wait_until([&] {
      const auto samples = heard();
      return !samples.empty() && std::abs(samples.back() - level) < 1e-3;
    });
  };
  REQUIRE(is(0.4));
  const auto before = heard().size();
  input.reset();
  REQUIRE(is(0.0));
  const auto samples = heard();
  double steepest = 0.0;
  for (std::size_t n = before; n < samples.size(); ++n)
    steepest = std::max(steepest, std::abs(samples[n] - samples[n - 1]));
  CHECK(steepest <= conservative_limits().slew_per_second / 48e3 + 1e-6);
}

TEST_CASE("play: after 5 s of SIGSTOP the drives are disarmed", "[cards][slow]") {
  const auto server = test::start_sound_server({.synchronous = false});  // it runs on without the program
  const test::TemporaryFolder folder;
  const auto tone = folder.write("tone.toml", constant("0.2")).string();
  std::string logs;
  const bool disarmed =
      test::undisturbed("a server that answers", [&, take = 0]() mutable -> std::optional<bool> {
        const auto wav = folder.path() / ("take" + std::to_string(++take) + ".wav");
        Playing play{{tone, "--device", "jack:loopback", "--arm"}};
        REQUIRE(play.says("delay "));
        Playing listener{{tone, "--device", "jack:loopback", "--outputs", "2", "--record", wav.string()}};
        REQUIRE(listener.says("delay "));
        const auto frames = [&] { return read_wav(wav)->frames(); };
        REQUIRE(test::wait_until([&] { return frames() > 0; }));
        play.process().pause();
        const auto paused = frames();  // that the listener counts are the time
        const bool heard = test::wait_until([&] { return frames() > paused + 6 * 48'000; });
        play.process().send(SIGCONT);
        const bool silent = heard && play.says("all drives were disarmed") &&
                            test::wait_until([&] { return read_wav(wav)->channels.front().back() == 0.0; });
        logs = play.log() + listener.log();
        if (!silent && (listener.count("disconnected") > 0 || listener.count("does not respond") > 0))
          return std::nullopt;
        return silent;
      });
  INFO(logs);
  CHECK(disarmed);
}
