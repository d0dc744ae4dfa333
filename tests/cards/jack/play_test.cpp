// The program itself, played by keys on a real server.
#include "tests/cards/jack/playing.h"
#include "tests/cards/ways.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::constant;
using test::OnServer;
using test::Playing;

TEST_CASE_METHOD(OnServer, "play: drives are silent until a key arms them", "[cards]") {
  const test::DelayClient card;
  for (const bool armed : {false, true}) {
    CAPTURE(armed);
    Playing play{{tone, "--device", card.name(), "--json", "--duration", "2 s"}};
    REQUIRE(play.says("the drives are disarmed"));
    if (armed) play.arm();
    REQUIRE(play.ends() == 0);
    const auto report = play.report();
    INFO(play.log());
    REQUIRE(report.is_object());
    CHECK((report["highest_input"]["heard"].get<double>() > 0.01) == armed);
  }
}

TEST_CASE_METHOD(OnServer,
                 "play: an edit is heard while it plays, and a broken one is told and changes nothing",
                 "[cards]") {
  const test::DelayClient card;
  folder.write("tone.toml", constant("0"));
  Playing play{{tone, "--device", card.name(), "--arm", "--json", "--duration", "4 s"}};
  REQUIRE(play.says("delay "));
  folder.write("tone.toml", constant("0.2 + nothing"));
  CHECK(play.says("tone.toml:6:"));
  CHECK(play.says("the previous version keeps playing"));
  folder.write("tone.toml", constant("0.2"));
  CHECK(play.says("constant: edit applied"));
  CHECK(play.ends() == 0);
  CHECK(play.report()["highest_input"]["heard"].get<double>() > 0.01);
}

TEST_CASE_METHOD(OnServer, "play: ports go to the channels that were asked for", "[cards]") {
  Playing play{{tone, "--device", "jack:system", "--inputs", "2", "--outputs", "5"}};
  REQUIRE(play.says("delay "));
  CHECK(server->connections("system:capture_2") == "tactus:in_1\n");
  CHECK(server->connections("system:playback_5") == "tactus:out_1\n");
  CHECK(server->connections("system:playback_1").empty());
  play.process().send(SIGINT);
  CHECK(play.ends() == 5);
}

TEST_CASE_METHOD(OnServer,
                 "play: it waits for a server that died, plays on when it is back, and ends when told",
                 "[cards]") {
  Playing play{{tone, "--device", "jack:system"}};
  REQUIRE(play.says("delay "));
  server->kill();
  CHECK(play.says("disconnected"));
  server->restart();
  CHECK(play.says("reconnected after"));
  play.press("q");
  CHECK(play.ends() == 0);
}

TEST_CASE_METHOD(OnServer,
                 "play: a device that is not there, or not one alone, is refused with those that are",
                 "[cards]") {
  const test::DelayClient one{{.name = "twin"}}, two{{.name = "twins"}};
  const auto refused = [&](const std::string& device) {
    Playing play{{tone, "--device", device}};
    CHECK(play.ends() == 4);
    return play.log();
  };
  const auto missing = refused("jack:soundblaster");
  CHECK(missing.find("there is no device 'jack:soundblaster'") != std::string::npos);
  CHECK(missing.find("'jack:system'") != std::string::npos);
  const auto both = refused("twin");
  CHECK(both.find("'twin' matches several devices") != std::string::npos);
  CHECK(both.find("'jack:" + two.name() + "'") != std::string::npos);
}

TEST_CASE_METHOD(OnServer, "play: a simulated world is heard, and space strikes in it", "[cards]") {
  const std::string scene = TACTUS_SOURCE_DIR "/instruments/haptic_drum/single_strike.toml";
  Playing play{{scene, "--listen", "--device", "jack:system", "--json", "--duration", "1 s"}};
  REQUIRE(play.says("block "));
  play.press(" ");
  REQUIRE(play.ends() == 0);
  CHECK(play.report()["highest_output"]["sound"].get<double>() > 1e-3);
  CHECK(play.log().find("nothing to strike") == std::string::npos);
}

TEST_CASE_METHOD(
    OnServer,
    "play: what was recorded while it was armed, turned, edited and lost its server replays bit for bit",
    "[cards]") {
  const auto wav = in_folder("take.wav");
  folder.write("tone.toml", constant("0.1"));
  Playing play{{tone, "--device", "loopback", "--backend", "jack", "--record", wav}};
  REQUIRE(play.says("delay "));
  play.arm();
  folder.write("tone.toml", constant("0.2"));
  CHECK(play.says("constant: edit applied"));
  server->kill();
  CHECK(play.says("disconnected"));
  server->restart();
  CHECK(play.says("reconnected after"));
  play.press("q");
  CHECK(play.ends() == 0);
  // A stream that begins again is another take.
  for (const auto* take : {"take.wav", "take-2.wav"}) {
    test::ChildProcess replay{{TACTUS_PROGRAM, "render", "--replay", in_folder(take)},
                              test::ChildProcess::Stdout::Logged};
    CHECK(replay.wait(20s) == 0);
    CHECK_THAT(replay.log(), Catch::Contains("bit for bit"));
  }
}

TEST_CASE_METHOD(OnServer, "play: a rig is made from what is proposed, and plays", "[cards]") {
  const auto rig = in_folder("rig.toml");
  Playing first{{tone, "--device", "jack:system", "--save-rig", rig, "--yes", "--duration", "0.2 s"}};
  CHECK(first.ends() == 0);
  CHECK(first.says(rig + " is written"));
  Playing second{{tone, "--rig", rig, "--duration", "0.2 s", "--pad-delay", "20 ms"}};
  CHECK(second.ends() == 2);
  CHECK_THAT(second.log(), Catch::Contains("--pad-delay"));  // it was never measured
  Playing third{{tone, "--rig", rig, "--duration", "0.2 s", "--delay", "12 ms", "--pad-delay", "20 ms"}};
  CHECK(third.ends() == 0);
  CHECK_THAT(third.log(), Catch::Contains("12.00 ms assumed (--delay), extended to 20.00 ms by 384 frames"));
}

TEST_CASE_METHOD(OnServer, "play: five soft hits teach the rig how sensitive a sensor is", "[cards]") {
  // Somebody else plays the hits: five bursts, half a second apart, 30 dB below full scale.
  folder.write("hits.toml", R"(format = 1
name = "hits"
[nodes]
slow = { type = "sine", frequency = "2 Hz" }
beat = { type = "threshold", in = "slow", level = 0.5 }
hit  = { type = "decay", trigger = "beat", time = "5 ms" }
wave = { type = "sine", frequency = "1 kHz" }
[outputs]
out = { from = "0.0316 * hit * wave", kind = "audio" }
)");
  const auto rig = in_folder("rig.toml"), source = in_folder("source.toml");
  const std::string device = "format = 1\n[device]\noutput = \"jack:loopback\"\n";
  folder.write("source.toml", device + "[outputs]\nout = { channel = 1 }\n");
  folder.write("rig.toml", device + "[inputs]\nheard = { channel = 1 }\n[outputs]\ntone = { channel = 1 }\n");
  Playing hits{{in_folder("hits.toml"), "--rig", source, "--duration", "8 s"}};
  REQUIRE(hits.says("delay "));
  Playing play{{tone, "--rig", rig, "--learn", "--duration", "0.2 s"}};
  CHECK(play.says("hit softly five times (Ctrl-C ends): heard"));
  CHECK(play.ends() == 0);
  CHECK(play.says("a soft hit peaks at"));
  CHECK_THAT(play.log(), Catch::Contains("1 2 3 4 5"));
}

TEST_CASE_METHOD(OnServer, "play: what was pressed while the device was away holds when it is back",
                 "[cards]") {
  Playing play{{tone, "--device", "jack:loopback", "--arm", "--json"}};
  REQUIRE(play.says("delay "));
  server->kill();
  REQUIRE(play.says("disconnected"));
  play.press("a");
  REQUIRE(play.says("drives disarmed"));
  server->restart();
  REQUIRE(play.says("reconnected after"));
  // Whoever listens to what the card plays hears nothing.
  Playing listener{{tone, "--device", "jack:loopback", "--json", "--duration", "1 s"}};
  CHECK(listener.ends() == 0);
  CHECK(listener.report()["highest_input"]["heard"] == 0.0);
  play.press("q");
  CHECK(play.ends() == 0);
}

TEST_CASE_METHOD(OnServer, "play: controls are where the user left them when the device is back", "[cards]") {
  folder.write("level.toml",
               "format = 1\nname = \"level\"\n[inputs]\nheard = {}\n[controls]\n"
               "level = { value = 0.4, range = [0, 1] }\n[nodes]\n"
               "wave = { type = \"sine\", frequency = \"100 Hz\" }\n"
               "[outputs]\ntone = { from = \"level * wave + 0 * heard\" }\n");
  const auto heard = [&] {
    Playing listener{{tone, "--device", "jack:loopback", "--outputs", "2", "--json", "--duration", "1 s"}};
    CHECK(listener.ends() == 0);
    return listener.report()["highest_input"]["heard"].get<double>();
  };
  Playing play{{in_folder("level.toml"), "--device", "jack:loopback", "--arm"}};
  REQUIRE(play.says("delay "));
  CHECK(test::wait_until([&] { return heard() > 0.35; }));    // the soft start is over
  for (int turn = 0; turn < 7; ++turn) play.press("\x1b[D");  // left, by a twentieth of the range
  CHECK(test::wait_until([&] { return heard() < 0.06; }));
  server->kill();
  REQUIRE(play.says("disconnected"));
  server->restart();
  REQUIRE(play.says("reconnected after"));
  CHECK(test::wait_until([&] { return heard() > 0.04; }));  // armed, and its soft start is over
  CHECK(heard() < 0.06);
  play.press("q");
  CHECK(play.ends() == 0);
  CHECK(play.log().find("drives disarmed") == std::string::npos);
}

TEST_CASE_METHOD(OnServer, "play: a program that writes to a drive's port disarms it, and keeps it disarmed",
                 "[cards]") {
  const test::DelayClient card, other{{.name = "other"}};
  const auto port = card.name() + ":playback_1", writer = other.name() + ":capture_1";
  const auto begin = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {tone, "--device", card.name(), "--json"});
    return std::make_unique<Playing>(more);
  };
  auto play = begin({"--arm"});
  REQUIRE(play->says("delay "));
  server->connect("tactus:out_1", other.name() + ":playback_1");  // it only reads
  server->connect(writer, port);
  CHECK(play->says("'" + writer + "' also writes to '" + port + "'"));
  CHECK(play->says("drives disarmed"));
  play->arm("the drives stay disarmed");
  CHECK(play->log().find("--shared-port") != std::string::npos);
  play->press("q");
  CHECK(play->ends() == 0);

  play = begin({"--arm", "--duration", "2 s"});  // it is there from the beginning
  CHECK(play->ends() == 0);
  CHECK(play->report()["highest_output"]["tone"] == 0.0);

  play = begin({"--arm", "--shared-port", "--duration", "2 s"});
  CHECK(play->ends() == 0);
  CHECK(play->report()["highest_output"]["tone"].get<double>() > 0.1);
}

TEST_CASE_METHOD(OnServer, "play: a drive that is connected to another port of its device is disarmed",
                 "[cards]") {
  const test::DelayClient card{{.channels = 2}}, other{{.name = "other"}};
  Playing play{{tone, "--device", card.name(), "--outputs", "1", "--arm", "--json"}};
  REQUIRE(play.says("delay "));
  server->connect("tactus:out_1", other.name() + ":playback_1");  // it is no part of the device
  server->connect("tactus:out_1", card.name() + ":playback_2");
  CHECK(play.says("'tactus:out_1' also writes to '" + card.name() + ":playback_2'"));
  CHECK(play.says("drives disarmed"));
  play.press("q");
  CHECK(play.ends() == 0);
}

TEST_CASE_METHOD(OnServer,
                 "play: where other writers cannot be seen, drives are armed with --shared-port alone",
                 "[cards]") {
  for (const auto& way : test::every_way()) {
    if (way.alsa) continue;
    CAPTURE(way.name);
    Playing play{{tone, "--device", way.name + ":loopback", "--arm", "--json"}};
    REQUIRE(play.says("delay "));
    CHECK(
        play.says("drives disarmed: this library does not show who else writes to the ports of the drives"));
    play.arm("the drives stay disarmed");
    play.press("q");
    CHECK(play.ends() == 0);
    CHECK(play.report()["highest_output"]["tone"] == 0.0);
    Playing shared{
        {tone, "--device", way.name + ":loopback", "--arm", "--shared-port", "--json", "--duration", "2 s"}};
    CHECK(shared.ends() == 0);
    CHECK(shared.report()["highest_output"]["tone"].get<double>() > 0.1);
  }
}

TEST_CASE_METHOD(OnServer, "play: a program that disconnects a drive disarms it", "[cards]") {
  const test::DelayClient card;
  Playing play{{tone, "--device", card.name(), "--arm", "--json"}};
  REQUIRE(play.says("delay "));
  server->disconnect("tactus");
  CHECK(play.says("drives disarmed: another program disconnected an output"));
  server->connect("tactus:out_1", card.name() + ":playback_1");
  CHECK(play.says("another program connected"));
  CHECK(play.count("drives disarmed") == 1);
  play.arm();  // it is the user's connection
  play.press("q");
  CHECK(play.ends() == 0);
}

TEST_CASE_METHOD(OnServer, "play: another block size disarms", "[cards]") {
  Playing play{{tone, "--device", "jack:system", "--arm"}};
  REQUIRE(play.says("delay "));
  server->set_period(512);
  CHECK(play.says("the block size is now 512 frames instead of 256"));
  CHECK(play.says("drives disarmed"));
  play.press("q");
  CHECK(play.ends() == 0);
}

TEST_CASE_METHOD(OnServer, "play: a rig names its device exactly, with its backend", "[cards]") {
  const auto refused = [&](const std::string& id, std::vector<std::string> more) {
    folder.write("rig.toml",
                 "format = 1\n[device]\noutput = \"" + id +
                     "\"\n[inputs]\nheard = { channel = 1 }\n[outputs]\ntone = { channel = 1 }\n");
    more.insert(more.begin(), {tone, "--rig", in_folder("rig.toml"), "--duration", "0.2 s"});
    Playing play{more};
    CHECK(play.ends() != 0);
    return play.log();
  };
  CHECK_THAT(refused("jack:loop", {}), Catch::Contains("there is no device 'jack:loop'"));
  CHECK_THAT(refused("jack:system", {"--backend", "jack"}), Catch::Contains("--backend"));
  // A person may write a part, and is told what it means.
  Playing play{{tone, "--device", "loopb", "--backend", "jack", "--duration", "0.2 s"}};
  CHECK(play.ends() == 0);
  CHECK_THAT(play.log(), Catch::Contains("--device loopb is jack:loopback"));
}

TEST_CASE_METHOD(OnServer, "play: with standard input closed nothing is taken for a key", "[cards]") {
  const auto command =
      std::string{"exec "} + TACTUS_PROGRAM + " play " + tone + " --device jack:system --duration '1 s' <&-";
  test::ChildProcess play{{"sh", "-c", command}, test::ChildProcess::Stdout::Logged};
  CHECK(play.wait(10s) == 0);
  CHECK(play.log().find("keys:") == std::string::npos);
  CHECK(play.log().find("drives armed") == std::string::npos);
}

TEST_CASE_METHOD(OnServer, "play: nothing goes around a rig", "[cards]") {
  folder.write(
      "rig.toml",
      "format = 1\n[device]\noutput = \"jack:system\"\nblock = 64\n[inputs]\nheard = { channel = 1 }\n"
      "[outputs]\ntone = { channel = 1 }\n[delay]\nmeasured = \"12 ms\"\n");
  const auto rig = in_folder("rig.toml");
  const auto refused = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {tone, "--rig", rig, "--duration", "0.2 s"});
    Playing play{more};
    CHECK(play.ends() == 2);
    return play.log();
  };
  CHECK_THAT(refused({"--outputs", "2"}), Catch::Contains("--outputs: cannot be combined with --rig"));
  CHECK_THAT(refused({"--inputs", "2"}), Catch::Contains("--inputs: cannot be combined with --rig"));
  CHECK_THAT(refused({"--device", "jack:loopback"}),
             Catch::Contains("--device: cannot be combined with --rig"));
  CHECK_THAT(refused({"--backend", "jack"}), Catch::Contains("--backend: cannot be combined with --rig"));
  CHECK_THAT(refused({"--profile", "voice_coil", "--volts-per-full-scale", "1"}),
             Catch::Contains("--profile: cannot be combined with a rig"));
  // The delay was measured with 64 frames a block, and this server has 256.
  CHECK_THAT(refused({"--pad-delay", "20 ms"}), Catch::Contains("the padding is unknown"));
  Playing play{{tone, "--rig", rig, "--duration", "0.2 s"}};
  CHECK(play.ends() == 0);
  CHECK_THAT(play.log(), Catch::Contains("treated as unknown"));
}

TEST_CASE_METHOD(
    OnServer,
    "play: what only a sound card has is refused without one, and ports that share a channel always",
    "[cards]") {
  folder.write("two.toml", "format = 1\n[outputs]\na = { from = \"0.1\" }\nb = { from = \"0.2\" }\n");
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--arm"}, {"--record", "take.wav"}, {"--device", ""}}) {
    CAPTURE(more.front());
    auto arguments = more;
    arguments.insert(arguments.begin(), tone);
    Playing play{arguments};
    CHECK(play.ends() == 2);
  }
  Playing both{{in_folder("two.toml"), "--device", "jack:system", "--outputs", "2,2"}};
  CHECK(both.ends() == 2);
  CHECK_THAT(both.log(), Catch::Contains("two outputs share a channel"));
}
