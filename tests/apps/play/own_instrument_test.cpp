#include <sys/wait.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "backends/wav_file.h"
#include "tests/support/temporary_folder.h"

// What a user's own instrument does in the commands, without a scene.

using namespace tactus;

namespace {

constexpr const char* kShaker = R"(
format = 1
name = "my shaker"
[inputs]
mic = { unit = "full scale" }
[nodes]
hit = { type = "onset", in = "mic", threshold = "-30 dB" }
env = { type = "decay", trigger = "hit", time = "50 ms" }
tone = { type = "sine", frequency = "60 Hz" }
[outputs]
shaker = { from = "0.4 * env * tone" }
)";

struct Ran {
  int exit;
  std::string text;  ///< of stdout and stderr
};

struct Folder {
  test::TemporaryFolder temporary;
  std::filesystem::path path = temporary.path();

  void write(const char* name, const std::string& text) const { std::ofstream{path / name} << text; }
  Ran run(const std::string& arguments) const {
    const auto command = "cd " + path.string() + " && " TACTUS_PROGRAM " " + arguments + " 2>&1 </dev/null";
    auto* pipe = popen(command.c_str(), "r");
    std::string text;
    for (std::array<char, 4096> part{}; const auto read = std::fread(part.data(), 1, part.size(), pipe);)
      text.append(part.data(), read);
    return {WEXITSTATUS(pclose(pipe)), text};
  }
};

bool has(const Ran& ran, const char* text) { return ran.text.find(text) != std::string::npos; }

}  // namespace

TEST_CASE("own instrument: play runs it on a test signal, and says what else there is", "[apps]") {
  const Folder folder;
  folder.write("my.toml", kShaker);
  const auto ran = folder.run("play my.toml --duration '1 s'");
  INFO(ran.text);
  CHECK(ran.exit == 0);
  CHECK(has(ran, "2 strikes per second at mic"));
  CHECK(has(ran, "--in FILE"));
  CHECK(std::filesystem::exists(folder.path / "out/my_shaker.svg"));
  const auto drives = read_wav(folder.path / "out/my_shaker_drives.wav");
  REQUIRE(drives);
  CHECK(drives->frames() == 48000);
  double peak = 0;
  for (const double sample : drives->channels[0]) peak = std::max(peak, std::abs(sample));
  CHECK(peak > 0.2);  // 0.4 at the crest of the first period: e^(-4 ms / 50 ms) 0.4
}

TEST_CASE("own instrument: a sound file at its inputs is played to the bit, with its rate and duration",
          "[apps]") {
  const Folder folder;
  folder.write("pass.toml",
               "format = 1\nname = \"pass\"\n[inputs]\na = {}\nb = {}\n[outputs]\no = { from = \"a\", kind = "
               "\"audio\" }\n");
  Samples samples{Hertz{44100}, {std::vector<double>(4410)}};
  for (std::size_t n = 0; n < 4410; ++n) samples.channels[0][n] = static_cast<double>(n % 100) / 256.0;
  REQUIRE(write_wav(folder.path / "in file.wav", samples));
  const auto ran = folder.run("play pass.toml --in 'in file.wav'");
  INFO(ran.text);
  CHECK(ran.exit == 0);
  CHECK(has(ran, "0.1 s at 44100 Hz"));
  CHECK(has(ran, "in file.wav at a"));
  CHECK(has(ran, "silence at b"));
  const auto sensors = read_wav(folder.path / "out/pass_sensors.wav");
  REQUIRE(sensors);
  CHECK(sensors->channels[0] == samples.channels[0]);
  CHECK(sensors->channels[1] == std::vector<double>(4410, 0.0));
}

TEST_CASE("own instrument: inputs that cannot be are refused with what can", "[apps]") {
  const Folder folder;
  folder.write("my.toml", kShaker);
  for (const auto& [arguments, text] :
       {std::pair{"play my.toml --in nothing.wav", "name a WAV file, or test-signal, silence or keyboard"},
        {"play my.toml --in keyboard", "add --listen"},
        {"play my.toml --in silence --backend loop --device loop:cable", "the inputs of a sound card are"},
        {"play " TACTUS_SOURCE_DIR "/instruments/wall/scene.toml --in silence", "is a scene"},
        {"play " TACTUS_SOURCE_DIR "/instruments/wall/scene.toml --backend loop --device loop:cable",
         "play its instrument, " TACTUS_SOURCE_DIR "/instruments/wall/instrument.toml"}}) {
    const auto ran = folder.run(arguments);
    INFO(arguments << "\n" << ran.text);
    CHECK(ran.exit == 2);
    CHECK(has(ran, text));
  }
}

TEST_CASE("own instrument: its errors come with their place, and nothing else", "[apps]") {
  const Folder folder;
  folder.write("bad.toml", "format = 1\n[inputs]\nmic = {}\n[outputs]\no = { from = \"mik\" }\n");
  const auto ran = folder.run("play bad.toml");
  INFO(ran.text);
  CHECK(ran.exit == 3);
  CHECK(ran.text.starts_with("bad.toml:5:"));
  CHECK(std::count(ran.text.begin(), ran.text.end(), '\n') == 1);
}

TEST_CASE("own instrument: a folder without scene.toml is its instrument, or names its scenes", "[apps]") {
  const Folder folder;
  std::filesystem::create_directories(folder.path / "one");
  std::filesystem::create_directories(folder.path / "two");
  std::filesystem::create_directories(folder.path / "none");
  folder.write("one/instrument.toml", kShaker);
  folder.write("two/soft.toml",
               "format = 1\nduration = \"1 s\"\n[parts]\ninstrument = { use = \"i.toml\" }\n");
  CHECK(folder.run("play one --duration '0.1 s'").exit == 0);
  for (const auto* command : {"play", "check", "explain", "render"}) {
    const auto ran = folder.run(std::string{command} + " two");
    INFO(command << "\n" << ran.text);
    CHECK(ran.exit == 3);
    CHECK(has(ran, "name one of two/soft.toml"));
  }
  CHECK(has(folder.run("play ."), "name one of ./one"));
  CHECK(has(folder.run("play none"), "this folder has no scene.toml and no instrument.toml"));
}

TEST_CASE("own instrument: a scene without a plant plays, with its inputs as it gives them", "[apps]") {
  const Folder folder;
  folder.write("my.toml", kShaker);
  folder.write(
      "scene.toml",
      "format = 1\nduration = \"1 s\"\n[parts]\ninstrument = { use = \"my.toml\", mic = \"stroke\" "
      "}\n[gestures]\nstroke = { points = [[\"0 s\", 0], [\"0.5 s\", 0], [\"0.501 s\", 0.5], [\"0.502 s\", "
      "0]] }\n[expect]\nhits = { measure = \"count\", of = \"instrument.hit\", min = 1, max = 1 }\n");
  const auto ran = folder.run("play .");
  INFO(ran.text);
  CHECK(ran.exit == 0);
  CHECK(has(ran, "ok    hits"));
}

TEST_CASE("own instrument: a window that the run does not reach is not judged", "[apps]") {
  const Folder folder;
  const auto ran = folder.run("play " TACTUS_SOURCE_DIR "/instruments/haptic_drum --duration '3 s'");
  INFO(ran.text);
  CHECK(ran.exit == 0);
  CHECK(has(ran, "--    even             not reached"));
  CHECK(has(ran, "ok    faults"));
  // The detent is reached after 1.2 s: too weak a pull before that is no failure.
  const auto detent = folder.run("play wall/detent.toml --duration '0.1 s'");
  CHECK(detent.exit == 0);
  CHECK(has(detent, "--    pull"));
}

TEST_CASE("own instrument: list shows it, and every name of the list plays", "[apps]") {
  const Folder folder;
  folder.write("my.toml", kShaker);
  const auto own = folder.run("list");
  CHECK(own.exit == 0);
  CHECK(has(own, "my.toml  instrument  my shaker"));
  CHECK(has(own, "wall/detent.toml"));
  CHECK_FALSE(has(own, "wall/plant.toml"));
  CHECK_FALSE(has(own, "profiles"));
  CHECK(folder.run("play wall/detent.toml --duration '0.01 s'").exit == 0);
  CHECK(folder.run("explain haptic_drum/instrument.toml").exit == 0);
}

TEST_CASE("own instrument: new makes a folder of each template that plays and is stable", "[apps]") {
  const Folder folder;
  const auto help = folder.run("new --help");
  for (const auto* name : {"knob", "drum", "bowed_string", "metronome", "slider", "wall"}) {
    CHECK(has(help, name));
    const auto made = folder.run(std::string{"new my_"} + name + " --from " + name);
    INFO(name << "\n" << made.text);
    CHECK(made.exit == 0);
    CHECK(std::filesystem::exists(folder.path / (std::string{"my_"} + name) / "README.md"));
    const auto played = folder.run(std::string{"play my_"} + name);
    INFO(played.text);
    CHECK(played.exit == 0);
    CHECK(has(played, "no intervention"));
    CHECK(folder.run(std::string{"play my_"} + name + "/instrument.toml --duration '0.5 s'").exit == 0);
    CHECK(folder.run(std::string{"check my_"} + name + " --quick").exit == 0);
    CHECK(has(folder.run("list"), (std::string{"instrument  my_"} + name).c_str()));
  }
  CHECK(folder.run("new my_knob").exit == 3);
  CHECK(has(folder.run("new other --from knub"), "did you mean 'knob'?"));
  CHECK(folder.run("new 'a;b'").exit == 2);
}

TEST_CASE("own instrument: a scene outside of the shipped folder finds the shipped profiles", "[apps]") {
  const Folder folder;
  std::filesystem::copy(TACTUS_SOURCE_DIR "/instruments/haptic_drum", folder.path / "mine");
  const auto ran = folder.run("play mine --duration '0.1 s'");
  INFO(ran.text);
  CHECK(ran.exit == 0);
}

TEST_CASE("command line: a word that is no command gets a suggestion, and JSON errors are JSON", "[apps]") {
  const Folder folder;
  for (const auto& [arguments, text] : {std::pair{"plya x", "did you mean 'play'?"},
                                        {"study wall", "there is no command 'study wall'"},
                                        {"study playabilty x", "did you mean 'playability'?"}}) {
    const auto ran = folder.run(arguments);
    INFO(arguments << "\n" << ran.text);
    CHECK(ran.exit == 2);
    CHECK(has(ran, text));
  }
  CHECK(has(folder.run("help play"), "--duration"));
  const auto json = folder.run("explain nothing.toml --json 2>/dev/null");
  CHECK(json.exit == 3);
  CHECK(has(json, "\"where\": \"nothing.toml\""));
}
