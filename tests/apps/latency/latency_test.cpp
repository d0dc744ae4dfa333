// The program itself, on files and on simulated cards.
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <numbers>

#include "apps/render/render.h"
#include "backends/backend.h"
#include "engine/dsp/generators/counter_noise.h"
#include "engine/rig/rig.h"
#include "latency/probe/probe.h"
#include "tests/support/child_process.h"
#include "tests/support/desk.h"
#include "tests/support/terminal_process.h"
#include "tests/support/wait_until.h"
#include "tests/support/well_formed.h"

using namespace tactus;
namespace fs = std::filesystem;

namespace {

using test::check_exit;
using test::text_of;

/// With what probes need.
class Desk : public test::Desk {
 public:
  /// What `tactus latency probe` writes, and a recording of it: later, with another gain, with noise.
  Samples probe(const std::string& rate = "48 kHz") const {
    REQUIRE(run("latency probe --out probe.wav --rate '" + rate + "'").exit == 0);
    return *read_wav(file("probe.wav"));
  }
  void capture(const std::string& name, const Samples& samples) const {
    REQUIRE(write_wav(file(name), samples));
  }
};

/// As a cable of so many frames brings it, and silence behind.
Samples later(const Samples& probe, int frames, double gain) {
  const CounterNoise noise{3, 0};
  Samples captured{probe.sample_rate, {{}}};
  auto& channel = captured.channels.front();
  channel.assign(static_cast<std::size_t>(frames), 0.0);
  for (const double sample : probe.channels.front()) channel.push_back(gain * sample);
  channel.resize(channel.size() + 24000, 0.0);
  for (std::size_t n = 0; n < channel.size(); ++n)
    channel[n] += 1e-4 * noise.gaussian(static_cast<std::int64_t>(n));
  return captured;
}

}  // namespace

TEST_CASE("latency analyze: a probe that was played and recorded gives its delay, gain and polarity",
          "[latency]") {
  const Desk desk;
  desk.capture("capture.wav", later(desk.probe(), 960, -0.5));
  const auto ran = desk.run("latency analyze capture.wav --played probe.wav --json");
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  const auto json = ran.json();
  REQUIRE(json.is_object());
  CHECK(json["verdict"] == "ok");
  CHECK(json["delay_frames"].get<double>() == Approx(960).epsilon(0).margin(0.01));
  CHECK(json["delay_ms"].get<double>() == Approx(20).epsilon(0).margin(0.01 / 48));
  CHECK(json["standard_error_frames"].get<double>() < 0.01);
  CHECK(json["polarity"] == -1);
  CHECK(json["gain_db"].get<double>() == Approx(20 * std::log10(0.5)).epsilon(0).margin(0.01));
  CHECK(json["noise_floor_dbfs"].get<double>() == Approx(-80).epsilon(0).margin(1));
  for (const char* key : {"snr_db", "drift_ppm", "bound_frames", "spread_over_sweeps_frames", "dc", "low_hz",
                          "high_hz", "harmonics_db", "group_delay", "steps", "sweeps", "what", "remedy",
                          "delay_is", "openings", "written"})
    CHECK(json.contains(key));
}

TEST_CASE("latency analyze: a recording without the probe is refused, without a delay but with the noise",
          "[latency]") {
  const Desk desk;
  desk.capture("capture.wav", later(desk.probe(), 960, 0.0));
  const auto ran = desk.run("latency analyze capture.wav --played probe.wav --json");
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 1);
  const auto json = ran.json();
  CHECK(json["verdict"] == "NO_SIGNAL");
  for (const char* key : {"delay_frames", "delay_ms", "standard_error_frames", "polarity"})
    CHECK(json[key].is_null());
  CHECK(json["noise_floor_dbfs"].get<double>() == Approx(-80).epsilon(0).margin(1));
  CHECK_FALSE(json["remedy"].get<std::string>().empty());
  const auto text = desk.run("latency analyze capture.wav --played probe.wav");
  CHECK(text.exit == 1);
  CHECK(text.out.starts_with("delay          not known: NO_SIGNAL\n"));
}

TEST_CASE("latency analyze: the probe is resampled to the capture's rate, or both are at --rate",
          "[latency]") {
  const Desk desk;
  const auto probe = desk.probe();
  auto other = app::resample(later(probe, 960, 0.5), 44100_Hz);
  desk.capture("other.wav", other);
  const auto resampled = desk.run("latency analyze other.wav --played probe.wav --json");
  INFO(resampled.err);
  CHECK(resampled.err.find("44100") != std::string::npos);
  CHECK(resampled.json()["sample_rate_hz"] == 44100);
  CHECK(resampled.json()["delay_frames"].get<double>() ==
        Approx(960 * 44100.0 / 48000).epsilon(0).margin(0.02));

  auto lying = later(probe, 960, 0.5);
  lying.sample_rate = 44100_Hz;
  desk.capture("lying.wav", lying);
  const auto corrected = desk.run("latency analyze lying.wav --played probe.wav --rate '48 kHz' --json");
  INFO(corrected.err);
  CHECK(corrected.json()["sample_rate_hz"] == 48000);
  CHECK(corrected.json()["delay_frames"].get<double>() == Approx(960).epsilon(0).margin(0.01));
}

TEST_CASE("latency analyze: a probe that cannot be in the recording is refused before any work",
          "[latency]") {
  const Desk desk;
  auto probe = desk.probe();
  desk.capture("capture.wav", later(probe, 960, 0.5));
  probe.sample_rate = Hertz{2936};  // as a broken header has it: 77 s
  REQUIRE(write_wav(desk.file("slow.wav"), probe));
  check_exit(desk.run("latency analyze capture.wav --played slow.wav"), 3, "slow.wav 2936");
}

TEST_CASE("latency analyze: a file with what was played in its first channel needs no probe", "[latency]") {
  const Desk desk;
  const auto probe = desk.probe();
  auto both = later(probe, 480, 0.5);
  both.channels.push_back(both.channels.front());  // channel 3
  both.channels.insert(both.channels.begin(), probe.channels.front());
  both.channels[0].resize(both.channels[1].size());
  both.channels[1].assign(both.channels[1].size(), 0.0);
  desk.capture("raw.wav", both);
  const auto ran = desk.run("latency analyze raw.wav --channel 3 --json");
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  CHECK(ran.json()["delay_frames"].get<double>() == Approx(480).epsilon(0).margin(0.01));
  CHECK(desk.run("latency analyze raw.wav --json").json()["verdict"] == "WRONG_CHANNEL");
  check_exit(desk.run("latency analyze raw.wav --channel 1"), 2, "channel 1");
  check_exit(desk.run("latency analyze raw.wav --channel 4"), 2, "'raw.wav' 4 2 3");
}

TEST_CASE("latency analyze: invalid files are reported one by one, with exit code 3", "[latency]") {
  const Desk desk;
  const auto probe = desk.probe();
  desk.capture("capture.wav", later(probe, 960, 0.5));
  desk.capture("empty.wav", {48_kHz, {{}}});
  desk.capture("short.wav", {48_kHz, {std::vector<double>(48000)}});
  desk.capture("slow.wav", {10_Hz, {std::vector<double>(48000)}});
  desk.capture("nan.wav", {48_kHz, {std::vector<double>(480000, std::nan(""))}});
  desk.capture("noise.wav", {48_kHz, {std::vector<double>(100)}});
  desk.folder.write("text.wav", "this is no sound");
  const auto analyze = [&](const std::string& arguments) { return desk.run("latency analyze " + arguments); };
  check_exit(analyze("nowhere.wav --played probe.wav"), 3, "nowhere.wav");
  check_exit(analyze("capture.wav --played nowhere.wav"), 3, "nowhere.wav");
  check_exit(analyze("empty.wav --played probe.wav"), 3, "empty.wav");
  check_exit(analyze("capture.wav --played empty.wav"), 3, "empty.wav");
  check_exit(analyze("short.wav --played probe.wav"), 1, "NO_SIGNAL");
  check_exit(analyze("slow.wav --played probe.wav"), 3, "slow.wav 10");
  check_exit(analyze("nan.wav --played probe.wav"), 3, "nan.wav");
  check_exit(analyze("text.wav --played probe.wav"), 3, "text.wav");
  check_exit(analyze("capture.wav"), 3, "capture.wav --played");
  CHECK(analyze("capture.wav --played noise.wav").exit == 3);
}

TEST_CASE("latency: wrong usage is reported, with exit code 2", "[latency]") {
  const Desk desk;
  desk.capture("capture.wav", later(desk.probe(), 960, 0.5));
  check_exit(desk.run("latency analyze capture.wav --played probe.wav --channel 2"), 2, "'capture.wav' 2 1");
  check_exit(desk.run("latency analyze capture.wav --played probe.wav --channel 0"), 2, "--channel");
  check_exit(desk.run("latency analyze capture.wav --played probe.wav --rate fast"), 2, "--rate");
  check_exit(desk.run("latency analyze capture.wav --played probe.wav --rate '10 Hz'"), 2, "--rate '10 Hz'");
  check_exit(desk.run("latency analyze"), 2, "FILE");
  check_exit(desk.run("latency probe"), 2, "--out");
  check_exit(desk.run("latency probe --out p.wav --level loud"), 2, "--level 'loud'");
  check_exit(desk.run("latency probe --out p.wav --level 3"), 2, "--level -120 0");
  check_exit(desk.run("latency probe --out p.wav --rate '44.1005 kHz'"), 2, "p.wav 44100.5");
  check_exit(desk.run("latency bogus"), 2, "bogus");
  check_exit(desk.run("latency measure --backend none"), 2, "'none'");
  check_exit(desk.run("latency measure --output 0"), 2, "--output");
  check_exit(desk.run("latency measure --rig nowhere.toml"), 3, "nowhere.toml");
  check_exit(desk.run("latency measure --rig nowhere.toml --block 64"), 2, "--block --rig");
  check_exit(desk.run("latency measure --device loop:20ms --input 3"), 2, "'loop:20ms' 3");
  check_exit(desk.run("latency measure --device loop:20ms --output 3"), 2, "'loop:20ms' 3");
  check_exit(desk.run("latency measure --device loop:nothing"), 4, "nothing");
  check_exit(desk.run("latency measure --device loop:20ms --rate '12.5 Hz'"), 2, "--rate '12.5 Hz'");
  check_exit(desk.run("latency sweep --blocks 0"), 2, "--blocks");
  check_exit(desk.run("latency sweep --device loop:20ms --rates 1"), 2, "--rates");
}

TEST_CASE("latency: alone it explains itself", "[latency]") {
  const auto ran = Desk{}.run("latency");
  CHECK(ran.exit == 0);
  for (const char* words : {"measure", "sweep", "probe", "analyze", "Examples:"})
    CHECK(ran.out.find(words) != std::string::npos);
}

TEST_CASE("latency probe: it is as loud and as long as it says", "[latency]") {
  const Desk desk;
  const auto ran = desk.run("latency probe --out p.wav --rate '96 kHz' --level '-20 dBFS' --json");
  CHECK(ran.exit == 0);
  const auto samples = read_wav(desk.file("p.wav"));
  REQUIRE(samples);
  CHECK(samples->sample_rate == 96_kHz);
  double peak = 0;
  for (const double sample : samples->channels.front()) peak = std::max(peak, std::abs(sample));
  CHECK(peak == Approx(0.1).epsilon(0.01));
  CHECK(ran.json()["duration_s"].get<double>() == Approx(static_cast<double>(samples->frames()) / 96000));
  check_exit(desk.run("latency probe --out nowhere/p.wav"), 3, "nowhere/p.wav");
}

namespace {

const std::string kShort = " --openings 2 --probes 2 --json";
const std::string kFast = ",real_time=0";

}  // namespace

TEST_CASE("latency measure: the delay of a card is found, reported and kept for it", "[latency]") {
  const Desk desk;
  const auto ran =
      desk.run("latency measure --device loop:20ms --block 64 --folder report --wav raw.wav" + kShort);
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  const auto json = ran.json();
  REQUIRE(json.is_object());
  CHECK(json["verdict"] == "ok");
  CHECK(json["delay_ms"].get<double>() == Approx(20).epsilon(0).margin(0.001));
  CHECK(json["openings"].size() == 2);
  for (const char* key : {"setting", "xruns", "xruns_by_cause", "lost_frames_counted", "reported_frames",
                          "spread_over_openings_frames", "kept"})
    CHECK(json.contains(key));
  CHECK(test::well_formed(text_of(desk.file("report/latency.svg"))));
  CHECK(nlohmann::json::parse(text_of(desk.file("report/latency.json")))["delay_frames"] ==
        json["delay_frames"]);

  const auto again = desk.run("latency analyze raw.wav --json");
  const auto kept = read_wav(desk.file("raw_2.wav"));
  REQUIRE(kept);
  CHECK(kept->channels.size() == 3);  // what was played, and two inputs
  CHECK(again.json()["delay_frames"].get<double>() ==
        Approx(json["openings"][0]["delay_frames"].get<double>()).epsilon(0).margin(1e-4));

  const auto devices = desk.run("devices --backend loop --json").json();
  int measured = 0;
  for (const auto& device : devices["devices"]) {
    if (!device.contains("measured_delay_s")) continue;
    ++measured;
    CHECK(device["id"] == "loop:20ms");
    CHECK(device["measured_delay_s"].get<double>() ==
          Approx(json["delay_ms"].get<double>() / 1e3).epsilon(1e-12));
  }
  CHECK(measured == 1);
}

TEST_CASE("latency measure: what was measured is what an instrument then reckons with, at that block alone",
          "[latency]") {
  const Desk desk;
  REQUIRE(desk.run("latency measure --device loop:20ms --block 64" + kShort).exit == 0);
  const auto play = std::string{"play "} + TACTUS_SOURCE_DIR +
                    "/instruments/haptic_drum --device loop:20ms --duration '0.1 s' --block ";
  check_exit(desk.run(play + "64"), 0, "delay 20.00 measured");
  check_exit(desk.run(play + "128"), 0, "delay not measured");
}

TEST_CASE("latency measure: a gamepad plays no probe", "[latency]") {
  const Desk desk;
  for (const auto& backend : haptic_backends()) {
    const auto id = backend.name + ":Wheel";
    check_exit(desk.run("latency measure --device " + id), 2, "--device '" + id + "' reports");
    desk.folder.write("rig.toml", "format = 1\n[device]\noutput = \"" + id + "\"\n");
    check_exit(desk.run("latency measure --rig rig.toml"), 3, "rig.toml:2 '" + id + "' reports");
  }
}

TEST_CASE("latency measure: a refusal has no delay, and keeps none", "[latency]") {
  const Desk desk;
  const auto ran = desk.run("latency measure --device loop:no_cable" + kFast + kShort);
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 1);
  CHECK(ran.json()["verdict"] == "NO_SIGNAL");
  for (const char* key : {"delay_frames", "delay_ms", "standard_error_frames"})
    CHECK(ran.json()[key].is_null());
  CHECK_FALSE(fs::exists(desk.state() / "tactus/delays.json"));
  CHECK(desk.run("latency measure --device loop:20ms,real_time=0 --no-save" + kShort).exit == 0);
  CHECK_FALSE(fs::exists(desk.state() / "tactus/delays.json"));
}

TEST_CASE("latency measure: a rig says what to measure, and keeps the delay beside all else", "[latency]") {
  const Desk desk;
  const std::string text =
      "format = 1\nname = \"my desk\"\n[device]\noutput = \"loop:20ms,real_time=0\"\nblock = 64\n"
      "[inputs]\nmicrophone = { channel = 2, sensitivity = \"50 mV\", volts_per_full_scale = \"1 V\" }\n"
      "[outputs]\nwoofer = { channel = 2, ceiling = 0.1 }\n[delay]\npad = \"40 ms\"\n";
  desk.folder.write("desk.toml", text);
  const auto ran = desk.run("latency measure --rig desk.toml" + kShort);
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  const auto json = ran.json();
  CHECK(json["source"].get<std::string>().find("output 2 to input 2") != std::string::npos);
  for (const auto& opening : json["openings"]) CHECK(opening["level_dbfs"].get<double>() <= -20);
  CHECK(text_of(desk.file("desk.toml~")) == text);
  const auto rig = load_rig(desk.file("desk.toml"), {});
  REQUIRE(rig);
  REQUIRE(rig->measured_delay);
  CHECK(rig->measured_delay->value == Approx(0.02).epsilon(0).margin(1e-6));
  CHECK(rig->pad_delay == Seconds{0.04});
  CHECK(rig->name == "my desk");
  CHECK(rig->inputs[0].scale() == Approx(20));
  CHECK(rig->device.rate == 48_kHz);
}

namespace {

/// The highest sample that the output ever had.
double highest_played(const Desk& desk) {
  const auto recording = read_wav(desk.file("raw.wav"));
  REQUIRE(recording);
  double highest = 0;
  for (const double sample : recording->channels.front()) highest = std::max(highest, std::abs(sample));
  return highest;
}

/// As loud as the slew limit of an unknown drive lets the highest frequency of the probe be.
double loudest_unknown() {
  const auto limits = conservative_limits();
  const double stop_hz = measuring_probe(48_kHz).stop.value;
  return std::min({limits.ceiling, limits.slew_per_second / (2 * std::numbers::pi * stop_hz), 0.5012});
}

const std::string kRecorded = " --no-save --wav raw.wav --openings 1 --probes 2 --json";

}  // namespace

TEST_CASE("latency measure: an output of which nothing is known is a drive, whatever comes back",
          "[latency]") {
  const Desk desk;
  const std::string card = GENERATE("loop:20ms", "loop:no_cable", "loop:wrong_channel", "loop:noise");
  CAPTURE(card);
  const auto ran = desk.run("latency measure --device " + card + kFast + kRecorded);
  INFO(ran.out << ran.err);
  CHECK(ran.err.find("--cable") != std::string::npos);
  CHECK(highest_played(desk) <= loudest_unknown());
  if (card == "loop:20ms") CHECK(ran.json()["verdict"] == "ok");
  if (card == "loop:no_cable") CHECK(ran.json()["verdict"] == "NO_SIGNAL");
  if (card == "loop:wrong_channel") CHECK(ran.json()["verdict"] == "WRONG_CHANNEL");
}

TEST_CASE("latency measure: a level that is asked for lowers the limits and never raises them", "[latency]") {
  const Desk desk;
  (void)desk.run("latency measure --device loop:no_cable,real_time=0 --level '-3 dBFS'" + kRecorded);
  CHECK(highest_played(desk) <= loudest_unknown());
  (void)desk.run("latency measure --device loop:no_cable,real_time=0 --level '-45 dBFS'" + kRecorded);
  CHECK(highest_played(desk) <= 0.00563);
}

TEST_CASE(
    "latency measure: with --cable level probes rise to the level, and no sweep does that is not captured",
    "[latency]") {
  const Desk desk;
  const std::string card = GENERATE("loop:no_cable", "loop:wrong_channel");
  CAPTURE(card);
  const auto ran = desk.run("latency measure --cable --device " + card + kFast + kRecorded);
  INFO(ran.out << ran.err);
  CHECK(ran.json()["verdict"] == (card == "loop:no_cable" ? "NO_SIGNAL" : "WRONG_CHANNEL"));
  CHECK(highest_played(desk) <= 0.5012);
  CHECK(highest_played(desk) > 0.4);
  CHECK(ran.json()["openings"][0]["level_dbfs"].get<double>() == Approx(-50).epsilon(0).margin(0.01));
}

TEST_CASE("latency measure: the high-pass of a card goes into the rig, for the output that was measured",
          "[latency]") {
  const Desk desk;
  desk.folder.write("desk.toml",
                    "format = 1\n[device]\noutput = \"loop:20ms,high_pass=8,noise=-100dB,real_time=0\"\n"
                    "[outputs]\nwoofer = { channel = 2 }\nsound = { channel = 1 }\n");
  const auto ran = desk.run("latency measure --rig desk.toml --input 2" + kShort);
  INFO(ran.out << ran.err);
  REQUIRE(ran.exit == 0);
  const auto json = ran.json();
  const double error = json["high_pass_standard_error_hz"].get<double>();
  CHECK(std::abs(json["high_pass_hz"].get<double>() - 8) < 4 * error);
  CHECK(error < 0.5);
  const auto rig = load_rig(desk.file("desk.toml"), {});
  REQUIRE(rig);
  REQUIRE(rig->outputs[0].highpass);
  CHECK(rig->outputs[0].highpass->value == Approx(8).margin(4 * error));
  CHECK_FALSE(rig->outputs[1].highpass);
}

TEST_CASE("latency measure: what the rig says of an output holds, from all its sections", "[latency]") {
  const Desk desk;
  desk.folder.write(
      "desk.toml",
      "format = 1\n[device]\noutput = \"loop:no_cable,real_time=0\"\n[outputs]\nwoofer = { channel = 2, "
      "ceiling = 0.01 }\n[actuators]\nshaker = { channel = 2, profile = \"fast.toml\", "
      "volts_per_full_scale = \"1 V\" }\n");
  desk.folder.write("fast.toml",
                    "format = 1\nname = \"x\"\n[drive]\nresistance = \"8 ohm\"\npeak = \"1 V\"\nsoft_start = "
                    "\"0 s\"\nfade_out = \"0 s\"\n");
  (void)desk.run("latency measure --rig desk.toml" + kRecorded);
  CHECK(highest_played(desk) <= 0.01);
  CHECK(highest_played(desk) > 0.009);
  // Nothing is said of the other one.
  (void)desk.run("latency measure --rig desk.toml --output 1" + kRecorded);
  CHECK(highest_played(desk) <= loudest_unknown());
  check_exit(desk.run("latency measure --rig desk.toml --cable"), 2, "--cable --device --rig");
  check_exit(desk.run("latency measure --rig desk.toml --backend loop"), 2, "--backend --rig");
}

TEST_CASE("latency sweep: delay per block and fixed delay are separated", "[latency]") {
  const Desk desk;
  const auto ran = desk.run("latency sweep --device loop:delay=100,blocks=2" + kFast +
                            " --blocks 64,128,256 --openings 1 --probes "
                            "2 --json "
                            "--svg blocks.svg");
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  const auto json = ran.json();
  REQUIRE(json["laws"].size() == 1);
  CHECK(json["laws"][0]["fixed_frames"].get<double>() == Approx(100).epsilon(0).margin(0.01));
  CHECK(json["laws"][0]["per_frame"].get<double>() == Approx(2).epsilon(0).margin(1e-4));
  CHECK(json["shortest"]["block_frames"] == 64);
  CHECK(test::well_formed(text_of(desk.file("blocks.svg"))));
}

TEST_CASE("latency sweep: Ctrl-C ends it, with exit code 5", "[latency]") {
  test::ChildProcess sweep{{TACTUS_PROGRAM, "latency", "sweep", "--device", "loop:20ms", "--blocks", "64"},
                           test::ChildProcess::Stdout::Logged};
  REQUIRE(test::wait_until([&] { return sweep.log().find("64 frames") != std::string::npos; }));
  sweep.send(SIGINT);
  CHECK(sweep.wait(std::chrono::seconds{5}) == 5);
}

TEST_CASE("latency: a terminal that is closed ends it, with exit code 5", "[latency]") {
  struct Case {
    std::string command, shown;
  };
  // Between two measurements as well as within one.
  const auto [command, shown] = GENERATE(Case{"measure", "opening 1 of"}, Case{"sweep", "16 frames"},
                                         Case{"sweep", "opening 1 of"}, Case{"calibrate", "opening 1 of"});
  CAPTURE(command, shown);
  const Desk desk;
  std::vector<std::string> words{TACTUS_PROGRAM, "latency", command, "--device", "loop:20ms"};
  if (command == "calibrate")
    for (const auto& word : {std::string{"--out"}, desk.file("path.toml").string(),
                             std::string{"--electrical"}, std::string{"1 ms"}})
      words.push_back(word);
  test::TerminalProcess program{words};
  REQUIRE(program.shows(shown));
  program.close();
  const auto ended = program.wait();
  REQUIRE(ended);
  CHECK(*ended == 5);
}

TEST_CASE("latency: a connection at standard input that is closed ends it, with exit code 5", "[latency]") {
  const std::string command = GENERATE(as<std::string>{}, "measure", "sweep", "calibrate");
  CAPTURE(command);
  const Desk desk;
  std::vector<std::string> words{TACTUS_PROGRAM, "latency", command, "--device", "loop:20ms"};
  if (command == "calibrate")
    for (const auto& word : {std::string{"--out"}, desk.file("path.toml").string(),
                             std::string{"--electrical"}, std::string{"1 ms"}})
      words.push_back(word);
  test::ChildProcess program{words, test::ChildProcess::Stdout::Logged};
  program.hang_up();
  CHECK(program.wait(std::chrono::seconds{5}) == 5);
  CHECK(program.log().find("standard input was closed") != std::string::npos);
}

TEST_CASE("latency calibrate: what lies in the loop becomes a profile, behind which the delay is found again",
          "[latency]") {
  const Desk desk;
  const std::string card = " --device loop:cable,high_pass=100,real_time=0 --block 64";
  check_exit(desk.run("latency calibrate --out path.toml" + card), 2, "--electrical");
  // 60.25 frames and two blocks, of which the profile takes 20 as its own.
  const auto ran = desk.run("latency calibrate --out path.toml --json --electrical '3.504375 ms'" + card);
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  CHECK(ran.json()["verdict"] == "ok");
  CHECK(ran.json()["polarity"] == 1);
  const auto found = desk.run("latency measure --no-save --through path.toml" + card + kShort);
  INFO(found.out << found.err);
  CHECK(found.exit == 0);
  CHECK(found.json()["delay_frames"].get<double>() == Approx(188.25 - 20.04).epsilon(0).margin(0.05));
  // At another rate the profile keeps its time, and the card its frames.
  const auto other =
      desk.run("latency measure --no-save --through path.toml --rate '44.1 kHz'" + card + kShort);
  INFO(other.out << other.err);
  CHECK(other.exit == 0);
  CHECK(other.json()["delay_frames"].get<double>() ==
        Approx(188.25 - 20.04 * 44.1 / 48).epsilon(0).margin(0.05));
  check_exit(desk.run("latency measure --through nowhere.toml" + card), 3, "nowhere.toml");
  desk.folder.write("broken.toml", "format = 1");
  check_exit(desk.run("latency measure --through broken.toml" + card), 3, "broken.toml 'path'");
}
