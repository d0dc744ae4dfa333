// The program itself, on files and on simulated cards.
#if defined(__unix__)
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "backends/resample.h"
#include "engine/dsp/counter_noise.h"
#include "engine/scene/rig.h"
#include "tests/engine/graph/temporary_folder.h"
#include "tests/support/well_formed.h"

using namespace tactus;
namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream in{file};
  return {std::istreambuf_iterator<char>{in}, {}};
}

struct Ran {
  int exit = -1;
  std::string out, err;
  nlohmann::json json() const { return nlohmann::json::parse(out, nullptr, false); }
};

/// A folder with the files of a test, where the program runs and keeps what it measures.
class Desk {
 public:
  Ran run(const std::string& arguments) const {
    const auto command = "cd " + folder.path().string() + " && XDG_STATE_HOME=" + state().string() + " " +
                         TACTUS_PROGRAM + " " + arguments + " > out.txt 2> err.txt < /dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(file("out.txt")), text_of(file("err.txt"))};
  }
  fs::path file(const std::string& name) const { return folder.path() / name; }
  fs::path state() const { return folder.path() / "state"; }

  /// What `tactus latency probe` writes, and a recording of it: later, with another gain, with noise.
  Samples probe(const std::string& rate = "48 kHz") const {
    REQUIRE(run("latency probe --out probe.wav --rate '" + rate + "'").exit == 0);
    return *read_wav(file("probe.wav"));
  }
  void capture(const std::string& name, const Samples& samples) const {
    REQUIRE(write_wav(file(name), samples));
  }

  test::TemporaryFolder folder;
};

/// As a cable of so many frames brings it, and silence behind.
Samples later(const Samples& probe, int frames, double gain) {
  const CounterNoise noise{3, 0};
  Samples heard{probe.sample_rate, {{}}};
  auto& channel = heard.channels.front();
  channel.assign(static_cast<std::size_t>(frames), 0.0);
  for (const double sample : probe.channels.front()) channel.push_back(gain * sample);
  channel.resize(channel.size() + 24000, 0.0);
  for (std::size_t n = 0; n < channel.size(); ++n)
    channel[n] += 1e-4 * noise.gaussian(static_cast<std::int64_t>(n));
  return heard;
}

void says(const Ran& ran, int exit, const std::string& words) {
  INFO(ran.out << ran.err);
  CHECK(ran.exit == exit);
  CHECK((ran.out + ran.err).find(words) != std::string::npos);
}

}  // namespace

TEST_CASE("latency analyze: a probe that was played and recorded gives its delay, gain and polarity",
          "[latency]") {
  const Desk desk;
  desk.capture("capture.wav", later(desk.probe(), 960, -0.5));
  const auto ran = desk.run("latency analyze capture.wav --probe probe.wav --json");
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  const auto json = ran.json();
  REQUIRE(json.is_object());
  CHECK(json["verdict"] == "ok");
  CHECK(json["delay_frames"].get<double>() == Approx(960).margin(0.01));
  CHECK(json["delay_ms"].get<double>() == Approx(20).margin(0.01 / 48));
  CHECK(json["standard_error_frames"].get<double>() < 0.01);
  CHECK(json["polarity"] == -1);
  CHECK(json["gain_db"].get<double>() == Approx(20 * std::log10(0.5)).margin(0.01));
  CHECK(json["noise_floor_dbfs"].get<double>() == Approx(-80).margin(1));
  for (const char* key : {"snr_db", "drift_ppm", "bound_frames", "spread_over_sweeps_frames", "dc", "low_hz",
                          "high_hz", "harmonics_db", "group_delay", "steps", "sweeps", "what", "remedy",
                          "delay_is", "openings", "written"})
    CHECK(json.contains(key));
}

TEST_CASE("latency analyze: a recording without the probe is refused, without a delay but with the noise",
          "[latency]") {
  const Desk desk;
  desk.capture("capture.wav", later(desk.probe(), 960, 0.0));
  const auto ran = desk.run("latency analyze capture.wav --probe probe.wav --json");
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 1);
  const auto json = ran.json();
  CHECK(json["verdict"] == "NO_SIGNAL");
  for (const char* key : {"delay_frames", "delay_ms", "standard_error_frames", "polarity"})
    CHECK(json[key].is_null());
  CHECK(json["noise_floor_dbfs"].get<double>() == Approx(-80).margin(1));
  CHECK_FALSE(json["remedy"].get<std::string>().empty());
  const auto text = desk.run("latency analyze capture.wav --probe probe.wav");
  CHECK(text.exit == 1);
  CHECK(text.out.starts_with("delay          not known: NO_SIGNAL\n"));
}

TEST_CASE("latency analyze: the probe is resampled to the capture's rate, or both are at --rate",
          "[latency]") {
  const Desk desk;
  const auto probe = desk.probe();
  auto other = resample(later(probe, 960, 0.5), 44100_Hz);
  desk.capture("other.wav", other);
  const auto resampled = desk.run("latency analyze other.wav --probe probe.wav --json");
  INFO(resampled.err);
  CHECK(resampled.err.find("the probe was resampled") != std::string::npos);
  CHECK(resampled.json()["sample_rate_hz"] == 44100);
  CHECK(resampled.json()["delay_frames"].get<double>() == Approx(960 * 44100.0 / 48000).margin(0.02));

  auto lying = later(probe, 960, 0.5);
  lying.sample_rate = 44100_Hz;
  desk.capture("lying.wav", lying);
  const auto corrected = desk.run("latency analyze lying.wav --probe probe.wav --rate '48 kHz' --json");
  INFO(corrected.err);
  CHECK(corrected.json()["sample_rate_hz"] == 48000);
  CHECK(corrected.json()["delay_frames"].get<double>() == Approx(960).margin(0.01));
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
  CHECK(ran.json()["delay_frames"].get<double>() == Approx(480).margin(0.01));
  CHECK(desk.run("latency analyze raw.wav --json").json()["verdict"] == "WRONG_CHANNEL");
  says(desk.run("latency analyze raw.wav --channel 1"), 2, "channel 1 is what was played");
  says(desk.run("latency analyze raw.wav --channel 4"), 2, "'raw.wav' has no channel 4; it has 2 to 3");
}

TEST_CASE("latency analyze: files that cannot be are told one by one, with exit code 3", "[latency]") {
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
  says(analyze("nowhere.wav --probe probe.wav"), 3, "nowhere.wav: there is no such file");
  says(analyze("capture.wav --probe nowhere.wav"), 3, "nowhere.wav: there is no such file");
  says(analyze("empty.wav --probe probe.wav"), 3, "empty.wav: it holds no samples");
  says(analyze("capture.wav --probe empty.wav"), 3, "empty.wav: it holds no samples");
  says(analyze("short.wav --probe probe.wav"), 3, "short.wav: it lasts 1.00 s, the probe 4.74 s");
  says(analyze("slow.wav --probe probe.wav"), 3, "its header says 10 Hz");
  says(analyze("nan.wav --probe probe.wav"), 3, "some of its samples are no numbers");
  says(analyze("text.wav --probe probe.wav"), 3, "cannot be read as a WAV file");
  says(analyze("capture.wav"), 3, "it has one channel, and nothing says what was played");
  CHECK(analyze("capture.wav --probe noise.wav").exit == 3);
}

TEST_CASE("latency: wrong usage is told, with exit code 2", "[latency]") {
  const Desk desk;
  desk.capture("capture.wav", later(desk.probe(), 960, 0.5));
  says(desk.run("latency analyze capture.wav --probe probe.wav --channel 2"), 2,
       "'capture.wav' has no channel 2; it has 1 alone");
  says(desk.run("latency analyze capture.wav --probe probe.wav --channel 0"), 2, "--channel");
  says(desk.run("latency analyze capture.wav --probe probe.wav --rate fast"), 2, "--rate");
  says(desk.run("latency analyze capture.wav --probe probe.wav --rate '10 Hz'"), 2, "from 1 kHz to 1 MHz");
  says(desk.run("latency analyze"), 2, "FILE is required");
  says(desk.run("latency probe"), 2, "--out is required");
  says(desk.run("latency probe --out p.wav --level loud"), 2, "'loud' is no level");
  says(desk.run("latency probe --out p.wav --level 3"), 2, "must be from -120 to 0 dBFS");
  says(desk.run("latency probe --out p.wav --rate '44.1005 kHz'"), 2, "whole number of hertz");
  says(desk.run("latency bogus"), 2, "bogus");
}

TEST_CASE("latency: alone it explains itself", "[latency]") {
  const auto ran = Desk{}.run("latency");
  CHECK(ran.exit == 0);
  for (const char* words : {"probe", "analyze", "Examples:"}) CHECK(ran.out.find(words) != std::string::npos);
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
  says(desk.run("latency probe --out nowhere/p.wav"), 3, "nowhere/p.wav: it cannot be written");
}
#endif
