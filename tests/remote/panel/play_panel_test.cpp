// The program itself, on a simulated card, with a panel and sensors.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "backends/take/take.h"
#include "tests/remote/panel/browser_client.h"
#include "tests/remote/serial/serial_device.h"
#include "tests/support/child_process.h"
#include "tests/support/desk.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::Json;
using test::wait_until;

namespace {

const std::string kTone = R"(format = 1
name = "tone"
[controls]
level = { value = 0.1, range = [0, 0.12], smooth = "0 ms" }
gain = { value = "-6 dB", range = ["-60 dB", "0 dB"] }
bend = { value = 0, range = [0, 1], smooth = "4 ms" }
[nodes]
wave = { type = "sine", frequency = "100 Hz", level = "level" }
[outputs]
tone = { from = "wave" }
other = { from = "0.01 * gain * bend" }
)";

/// `tactus play` with a panel at a free port.
struct Program {
  explicit Program(const test::Desk& desk, const std::vector<std::string>& more = {}) {
    const auto tone = desk.folder.write("tone.toml", kTone).string();
    std::vector<std::string> command = {"sh",           "-c",   "exec \"$0\" \"$@\" </dev/null",
                                        TACTUS_PROGRAM, "play", tone,
                                        "--backend",    "loop", "--panel",
                                        "--no-browser"};
    command.insert(command.end(), more.begin(), more.end());
    process.emplace(command, test::ChildProcess::Stdout::Logged);
    REQUIRE(wait_until([&] { return log().find("panel     http://127.0.0.1:") != std::string::npos; }));
    const auto text = log();
    const auto at = text.find("http://127.0.0.1:");
    link = text.substr(at, text.find('\n', at) - at);
  }
  std::string log() const { return process->log(); }
  bool says(const std::string& text) const {
    return wait_until([&] { return log().find(text) != std::string::npos; });
  }
  int stop() {
    process->send(SIGTERM);
    return process->wait(60s).value_or(-1);
  }

  std::optional<test::ChildProcess> process;
  std::string link;
};

std::size_t place_of(const Json& description, const std::string& control) {
  const auto& controls = description["controls"];
  for (std::size_t c = 0; c < controls.size(); ++c)
    if (controls[c]["name"] == control) return c;
  FAIL("there is no " << control);
  return 0;
}

/// Reads states until a control has this value.
bool wait_for_value(test::BrowserClient& browser, std::size_t control, double value) {
  return wait_until(
      [&] { return browser.wait_for("state")["controls"][control].get<double>() == Approx(value); });
}

}  // namespace

TEST_CASE("play: a take with panel, serial sensors and presets replays bit for bit", "[remote][live]") {
  const test::Desk desk;
  const auto wav = desk.file("take.wav");
  (void)desk.folder.write("presets/soft.toml",
                          "format = 1\n[controls]\nlevel = 0.02\ngain = \"-20 dB\"\nnone = 1\n");
  test::SerialDevice sensor{desk.file("port")};
  sensor.plug_in();
  Program play{desk, {"--record", wav.string(), "--serial", desk.file("port").string()}};
  test::BrowserClient browser{test::port_of(play.link)};
  REQUIRE(browser.open(play.link));
  const auto description = browser.wait_for("description");
  const auto level = place_of(description, "level"), gain = place_of(description, "gain"),
             bend = place_of(description, "bend");
  const auto send = [&](const Json& order) { browser.send(order.dump()); };

  send({{"do", "set"}, {"name", "level"}, {"value", 0.05}});
  CHECK(wait_for_value(browser, level, 0.05));
  send({{"do", "set"}, {"name", "gain"}, {"value", -30}, {"ramp", 0.2}});
  CHECK(wait_for_value(browser, gain, -30));
  for (int line = 1; line <= 20; ++line)
    sensor.send("@" + std::to_string(4000 * line) + " bend 0." + std::to_string(10 + line) + "\n");
  CHECK(wait_for_value(browser, bend, 0.3));
  send({{"do", "preset_recall"}, {"name", "soft"}, {"ramp", 0.1}});
  CHECK(wait_for_value(browser, gain, -20));
  CHECK(wait_for_value(browser, level, 0.02));
  CHECK(play.says("soft.toml:5:1: there is no control 'none'"));
  send({{"do", "preset_save"}, {"name", "new"}});
  CHECK(play.says("preset saved: "));

  send({{"do", "arm_request"}});
  send({{"do", "arm"}, {"number", browser.wait_for("answer")["number"]}});
  CHECK(play.says("drives armed by a remote client"));
  send({{"do", "scope"}, {"id", 1}, {"signals", {"out/tone"}}, {"bin", 1}});
  CHECK(browser.wait_for("scope")["signals"] == Json::array({"out/tone"}));
  CHECK(play.says("drives disarmed: the remote client that had armed them was silent for 0.5 s"));
  CHECK(play.stop() == 5);
  CHECK(play.log().find("serial    ") != std::string::npos);

  const auto take = read_take(wav);
  REQUIRE(take);
  const auto& names = take->header.controls;
  for (const auto* control : {"level", "gain", "bend"}) {
    INFO(control);
    const auto number = static_cast<int>(std::ranges::find(names, control) - names.begin());
    CHECK(std::ranges::count(take->engine, number, &JournalEntry::index) >= 2);
  }
  const auto replayed = desk.run("render --replay take.wav");
  INFO(replayed.out << replayed.err);
  CHECK(replayed.exit == 0);
  CHECK(replayed.out.find("bit for bit") != std::string::npos);
}

TEST_CASE("play: the scope of the panel shows the signal, frame for frame", "[remote][live]") {
  const test::Desk desk;
  Program play{desk};
  test::BrowserClient browser{test::port_of(play.link)};
  REQUIRE(browser.open(play.link));
  (void)browser.wait_for("description");
  browser.send(R"({"do":"scope","id":7,"signals":["level","out/tone"],"bin":1})");
  CHECK(browser.wait_for("scope")["id"] == 7);
  // A sine of 100 Hz from frame 0 on: sin(2 pi 100 n / 48000).
  int checked = 0;
  for (int chunk = 0; chunk < 20; ++chunk) {
    const auto frames = browser.wait_for_scope();
    REQUIRE(frames.traces.size() == 2);
    for (std::size_t n = 0; n < frames.traces[1].size(); ++n, ++checked) {
      const double phase = std::fmod(100.0 / 48e3 * (frames.frame + static_cast<double>(n)), 1.0);
      CHECK(frames.traces[0][n] == Approx(0.1));
      CHECK(frames.traces[1][n] == Approx(0.1 * std::sin(2 * std::numbers::pi * phase)).margin(2e-6));
    }
  }
  CHECK(checked == 20 * 64);
  CHECK(play.stop() == 5);
}

TEST_CASE("play: errors of an edit and the graph reach the panel", "[remote][live]") {
  const test::Desk desk;
  Program play{desk};
  test::BrowserClient browser{test::port_of(play.link)};
  REQUIRE(browser.open(play.link));
  REQUIRE(wait_until([&] {
    const auto description = browser.wait_for("description");
    return !description["text"].empty() && description["text"][0]["text"] == kTone;
  }));
  (void)desk.folder.write("tone.toml", kTone + "more = 3\n");
  const auto edit = browser.wait_for("edit");
  REQUIRE(edit["errors"].size() == 1);
  CHECK(edit["errors"][0]["line"] == 12);
  (void)desk.folder.write("tone.toml", kTone + "third = { from = \"0\" }\n");
  CHECK(browser.wait_for("edit")["errors"].size() == 1);  // another number of outputs
  (void)desk.folder.write("tone.toml", kTone);
  CHECK(browser.wait_for("edit")["errors"].empty());
  CHECK(play.stop() == 5);
}

TEST_CASE("play: an instrument that becomes a folder or has no end is an error of an edit",
          "[remote][live]") {
  const test::Desk desk;
  const bool folder = GENERATE(true, false);
  Program play{desk};
  test::BrowserClient browser{test::port_of(play.link)};
  REQUIRE(browser.open(play.link));
  REQUIRE(std::filesystem::remove(desk.file("tone.toml")));
  if (folder)
    std::filesystem::create_directory(desk.file("tone.toml"));
  else
    std::filesystem::create_symlink("/dev/zero", desk.file("tone.toml"));
  CHECK(browser.wait_for("edit")["errors"].size() == 1);
  CHECK(play.says(folder ? "this is a folder" : "this is not a regular file"));
  // It is drawn once more without the text of the file.
  CHECK(wait_until([&] { return browser.wait_for("description")["text"].empty(); }));
  CHECK(play.stop() == 5);
}

TEST_CASE("play: wrong options of panel and sensors are wrong usage", "[remote][live]") {
  const test::Desk desk;
  (void)desk.folder.write("tone.toml", kTone);
  test::check_exit(desk.run("play tone.toml --backend loop --panel nine"), 2, "nine port");
  test::check_exit(desk.run("play tone.toml --panel"), 2, "--panel card");
  test::check_exit(desk.run("play tone.toml --backend loop --panel-arm"), 2, "--panel-arm");
  test::check_exit(desk.run("play tone.toml --backend loop --panel 1.2.3.4:9000"), 2, "--panel 1.2.3.4:9000");
  test::check_exit(desk.run("play tone.toml --backend loop --serial /dev/none"), 4, "--serial /dev/none");
  test::check_exit(desk.run("play tone.toml --backend loop --serial /dev/none@x"), 2, "--serial");
}
