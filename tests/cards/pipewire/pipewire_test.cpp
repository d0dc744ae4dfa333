// The program on a real PipeWire server.
#include "tests/cards/pipewire/pipewire.h"

#include "tests/cards/jack/playing.h"
#include "tests/cards/ways.h"
#include "tests/support/skip.h"
#include "tests/support/undisturbed.h"

using namespace tactus;
using test::PipeWire;
using test::Playing;

namespace {

/// A server, and a file that plays 0.2.
struct OnPipeWire {
  PipeWire server;
  test::TemporaryFolder folder;
  std::string tone = folder.write("tone.toml", test::constant("0.2")).string();
};

const auto kOverJack = PipeWire::over_jack({TACTUS_PROGRAM, "play"});

double heard(Playing& play) {
  INFO(play.log());
  REQUIRE(play.report().is_object());
  return play.report()["highest_input"]["heard"];
}

/// [frames]
double measured(const std::string& device) {
  return test::undisturbed("frames were lost", [&]() -> std::optional<double> {
    test::ChildProcess latency{PipeWire::over_jack({TACTUS_PROGRAM, "latency", "measure", "--device", device,
                                                    "--openings", "1", "--json", "--cable", "--no-save"}),
                               test::ChildProcess::Stdout::Logged};
    const auto code = latency.wait(std::chrono::seconds{120});
    const auto log = latency.log();
    if (log.find("LOST_FRAMES") != std::string::npos) return std::nullopt;
    INFO(log);
    REQUIRE(code == 0);
    const auto report = nlohmann::json::parse(log.substr(log.find("{\n")), nullptr, false);
    REQUIRE(report.is_object());
    return report["delay_frames"].get<double>();
  });
}

std::string devices() {
  test::ChildProcess list{PipeWire::over_jack({TACTUS_PROGRAM, "devices"}),
                          test::ChildProcess::Stdout::Logged};
  CHECK(list.wait(std::chrono::seconds{60}) == 0);
  return list.log();
}

}  // namespace

TEST_CASE_METHOD(OnPipeWire, "pipewire: plays as the JACK server, and is heard", "[cards]") {
  Playing play{{tone, "--device", "jack:cable", "--arm", "--json", "--duration", "2 s"}, kOverJack};
  CHECK(play.ends() == 0);
  CHECK(heard(play) == Approx(0.2).margin(1e-6));
}

TEST_CASE_METHOD(OnPipeWire, "pipewire: the round trip over its JACK interface is one block", "[cards]") {
  for (const int block : {1024, 2048}) {
    server.force_block(block);
    CHECK_THAT(measured("jack:cable"), Catch::WithinAbs(block, 0.001));
  }
}

TEST_CASE_METHOD(OnPipeWire, "pipewire: through libraries it is one block too, or refused with what works",
                 "[cards]") {
  server.force_block(1024);
  if (test::has_backend("portaudio"))
    CHECK_THAT(measured("portaudio:jack:cable"), Catch::WithinAbs(1024, 0.001));
  if (!test::has_backend("rtaudio")) return;
  Playing play{{tone, "--device", "rtaudio:jack:cable"}, kOverJack};
  CHECK(play.ends() == 4);
  CHECK_THAT(play.log(), Catch::Contains("use --device 'jack:cable'"));
}

TEST_CASE_METHOD(OnPipeWire, "pipewire: another sample rate ends the stream until the granted one is back",
                 "[cards]") {
  Playing play{{tone, "--device", "jack:cable", "--arm", "--json"}, kOverJack};
  REQUIRE(play.says("delay "));
  server.force_rate(96000);
  CHECK(play.says("the sample rate is now 96000 Hz instead of 48000"));
  CHECK(play.says("disconnected"));
  CHECK(play.says("does not run at 48000 Hz"));
  server.force_rate(48000);
  CHECK(play.says("reconnected after"));
  play.press("q");
  CHECK(play.ends() == 0);
}

TEST_CASE_METHOD(OnPipeWire, "pipewire: as ALSA's default device it plays on when the graph changes its rate",
                 "[cards]") {
  if (!test::PipeWire::has_alsa())
    test::skip("ALSA does not reach PipeWire here (Debian: apt-get install pipewire-alsa)");
  for (const std::string backend : {"rtaudio", "portaudio"}) {
    if (!test::has_backend(backend)) continue;
    CAPTURE(backend);
    server.force_rate(48000);
    Playing play{{tone, "--device", backend + ":alsa:default", "--arm", "--json", "--duration", "5 s"}};
    REQUIRE(play.says("delay "));
    server.force_rate(96000);
    REQUIRE(test::wait_until([&] { return devices().find("96 kHz") != std::string::npos; }));
    CHECK(play.ends() == 0);
    CHECK(play.log().find("disconnected") == std::string::npos);
    CHECK(heard(play) > 0.1);  // the guard lowers what is constant
  }
}
