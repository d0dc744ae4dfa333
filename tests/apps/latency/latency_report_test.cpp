#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "apps/latency/latency.h"
#include "tests/support/well_formed.h"

using namespace tactus;
using namespace tactus::app;

namespace {

constexpr double kDelay = 960.25;

/// A cable with a coupling capacitor: a delayed pulse, noise 90 dB below, eight sweeps.
Analysis cable() {
  Analysis analysis;
  analysis.detected = true;
  analysis.delay_frames = kDelay;
  analysis.standard_error_frames = 0.0004;
  analysis.bound_frames = 0.0003;
  analysis.spread_frames = 0.0011;
  analysis.polarity = -1;
  analysis.gain_db = -6.02;
  analysis.snr_db = 71.3;
  analysis.noise_floor_dbfs = -96.4;
  analysis.dc = 0.0002;
  analysis.drift_ppm = 0.013;
  analysis.drift_standard_error_ppm = 0.02;
  analysis.low_hz = 12;
  analysis.high_hz = 20100;
  analysis.high_pass_hz = 3.4;
  analysis.harmonics_db = {-80.5, -91.0, std::nullopt, std::nullopt};
  for (double centre = 31.25; centre < 17e3; centre *= 2)
    analysis.group_delay.push_back({centre, kDelay - 40 / centre, 3 / centre});
  for (int k = 0; k < 8; ++k)
    analysis.probes.push_back({24000 + 22000 * k, kDelay + 0.001 * (k % 3 - 1), -6.02, 0.25});
  for (double f = 20; f < 24e3; f *= 1.02)
    analysis.spectrum.push_back({f, -6.02 - 10 * std::log10(1 + std::pow(12 / f, 2)), -96 + 3 * std::sin(f)});
  analysis.response_at = 900;
  for (int n = 0; n < 400; ++n) {
    const double x = std::numbers::pi * (900 + n - kDelay);
    analysis.response.push_back(-0.5 * std::sin(x) / x);
  }
  return analysis;
}

LatencyReport five_openings() {
  LatencyReport report;
  report.source = "loop:20ms, 48 kHz, 64 frames per block; output 1 to input 1";
  report.live = true;
  report.measurement.delay_frames = kDelay;
  report.measurement.standard_error_frames = 0.0004;
  report.measurement.spread_frames = 0.0009;
  report.measurement.reported_frames = 1024.0;
  for (int o = 0; o < 5; ++o) {
    Opening opening;
    opening.granted.device = "loop:20ms";
    opening.granted.format.sample_rate = 48_kHz;
    opening.granted.block_frames = 64;
    opening.granted.periods = 2;
    opening.health.xruns = o == 3 ? 2 : 0;
    opening.level_dbfs = -12;
    opening.analysis = cable();
    report.measurement.openings.push_back(opening);
  }
  return report;
}

LatencyReport refused() {
  auto report = five_openings();
  report.measurement.finding = {Verdict::LostFrames, "64 frames were lost at 1.50 s", "use larger blocks"};
  auto& opening = report.measurement.openings[2];
  opening.finding = report.measurement.finding;
  opening.analysis.steps = {{72000, -64}};
  return report;
}

bool contains(const std::string& text, const std::string& part) {
  INFO(text);
  CHECK(text.find(part) != std::string::npos);
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("latency report: the delay comes first, in frames and ms, with as many digits as its error leaves",
          "[latency]") {
  const auto text = text_of(five_openings());
  CHECK(text.starts_with("delay          960.2500 ± 0.0004 frames, 20.0052 ms\n"));
  contains(text, "driver         1024 frames: 63.8 frames more than measured\n");
  contains(text, "gaps           none detected; 2 counted by the driver, 0 frames\n");
  contains(text, "path           -6.02 dB, inverted, 12 Hz to 20.1 kHz within 3 dB\n");
  contains(text, "distortion     H2 -80 dB, H3 -91 dB\n");
  contains(text, "clock          drift 0.01 ± 0.02 ppm\n");
}

TEST_CASE("latency report: a refusal says its code, what was seen, what to do, and no delay", "[latency]") {
  const auto text = text_of(refused());
  CHECK(
      text.starts_with("delay          not known: LOST_FRAMES\n"
                       "cause          64 frames were lost at 1.50 s\n"
                       "remedy         use larger blocks\n"));
  contains(text, "gaps           lost 64 frames at 1.50 s; 2 counted by the driver");
  contains(text, "openings       960.250  960.250  LOST_FRAMES  960.250  960.250 [frames]\n");
}

TEST_CASE("latency report: the JSON of a refusal keeps the evidence and drops the delay", "[latency]") {
  const auto json = json_of(refused());
  CHECK(json["verdict"] == "LOST_FRAMES");
  CHECK(json["what"] == "64 frames were lost at 1.50 s");
  CHECK(json["remedy"] == "use larger blocks");
  for (const char* key : {"delay_frames", "delay_ms", "standard_error_frames"}) CHECK(json[key].is_null());
  CHECK(json["steps"][0]["frames"] == -64);
  CHECK(json["steps"][0]["at_s"] == 1.5);
  CHECK(json["snr_db"] == 71.3);
  CHECK(json["openings"][0]["delay_frames"] == kDelay);
  CHECK(json["openings"][2]["delay_frames"].is_null());
}

TEST_CASE("latency report: the JSON has every figure, and null where there is none", "[latency]") {
  auto report = five_openings();
  report.measurement.openings[0].analysis.drift_standard_error_ppm = std::nan("");
  const auto json = nlohmann::json::parse(json_of(report).dump());
  CHECK(json["delay_frames"] == kDelay);
  CHECK(json["delay_ms"].get<double>() == Approx(kDelay / 48));
  CHECK(json["polarity"] == -1);
  CHECK(json["verdict"] == "ok");
  CHECK(json["xruns"] == 2);
  CHECK(json["reported_frames"] == 1024);
  CHECK(json["harmonics_db"]["h2"] == -80.5);
  CHECK(json["harmonics_db"]["h4"].is_null());
  CHECK(json["drift_standard_error_ppm"].is_null());
  CHECK(json["openings"].size() == 5);
  CHECK(json["setting"]["block_frames"] == 64);
  CHECK(json["setting"]["input_device"] == "loop:20ms");
  CHECK(json["sweeps"].size() == 8);
}

TEST_CASE("latency report: of silence only its noise is printed", "[latency]") {
  LatencyReport report;
  report.source = "capture.wav";
  report.measurement.finding = {Verdict::NoSignal, "nothing came back", "connect the cable"};
  Opening opening;
  opening.finding = report.measurement.finding;
  opening.analysis.finding = opening.finding;
  opening.analysis.noise_floor_dbfs = -120;
  report.measurement.openings = {opening};
  const auto json = json_of(report);
  for (const char* key : {"polarity", "gain_db", "snr_db", "drift_ppm", "low_hz"}) CHECK(json[key].is_null());
  CHECK(json["noise_floor_dbfs"] == -120);
  CHECK_FALSE(json.contains("xruns"));
  contains(text_of(report), "noise          -120.0 dBFS, DC 0\n");
  CHECK(test::well_formed(to_svg(picture_of(report))));
}

TEST_CASE("latency report: what ended before it was played prints no unknown value", "[latency]") {
  LatencyReport report;
  report.live = true;
  report.measurement.finding = {Verdict::Feedback, "it howled", "switch monitoring off"};
  Opening opening;
  opening.finding = report.measurement.finding;
  opening.granted.format.sample_rate = 96_kHz;
  report.measurement.openings = {opening};
  const auto json = json_of(report);
  CHECK(json["noise_floor_dbfs"].is_null());
  CHECK(json["dc"].is_null());
  CHECK(json["sample_rate_hz"] == 96000);
  const auto text = text_of(report);
  CHECK(text.find("noise") == std::string::npos);
  contains(text, "openings       HOWL\n");
  contains(text, "gaps           none counted by the driver\n");
}

TEST_CASE("latency report: the picture is well-formed and has its axes with units", "[latency]") {
  for (const auto& report : {five_openings(), refused()}) {
    const auto svg = to_svg(picture_of(report));
    CHECK(test::well_formed(svg));
    for (const char* words :
         {"delay [ms]", "frequency", "gain of the path [dB]", "delay of each probe [frames]"})
      contains(svg, words);
    CHECK(svg.find("nan") == std::string::npos);
  }
  contains(to_svg(picture_of(five_openings())), "Delay 960.2500 ± 0.0004 frames, 20.0052 ms");
  contains(to_svg(picture_of(refused())), "No delay: LOST_FRAMES");
}

namespace {

SweepRow row(int block, double delay_frames, std::int64_t gaps = 0) {
  SweepRow row;
  row.asked_block = row.setting.block_frames = block;
  row.setting.periods = 2;
  row.setting.delay_frames = delay_frames;
  row.setting.standard_error_frames = 0.001;
  row.setting.gaps = row.xruns = gaps;
  row.setting.measured_s = 12;
  return row;
}

/// delay = 40 + 3 * block, with everything that a device may do to a request.
SweepReport swept() {
  SweepReport report;
  report.source = "rtaudio:alsa:card";
  auto refused = row(16, 0);
  refused.refused = Error{Errc::Device, "", "blocks of 16 frames cannot be had", ""};
  refused.setting.block_frames = 0;
  auto lost = row(32, 0, 5);
  lost.setting.finding = {Verdict::LostFrames, "32 frames were lost", "use larger blocks"};
  auto rounded = row(192, 40 + 3 * 192);
  rounded.asked_block = 200;
  auto again = row(192, 0);
  again.asked_block = 210;
  again.again = true;
  report.rows = {refused, lost,  row(64, 40 + 3 * 64, 1), row(128, 40 + 3 * 128),
                 rounded, again, row(256, 40 + 3 * 256)};
  return report;
}

}  // namespace

TEST_CASE("latency sweep: the table says what was refused, rounded, lost and measured", "[latency]") {
  const auto text = text_of(swept());
  contains(text, "refused: blocks of 16 frames cannot be had\n");
  contains(text, "LOST_FRAMES");
  contains(text, "200 requested\n");
  contains(text, "changed to one of these settings by the device or its server: 210 frames.");
  contains(text, "424.000 ± 0.001      8.833");
  contains(text, "x block   at 48 kHz, 2 periods; 3 settings");
  contains(text, "Play with 128 frames, 2 periods, 48 kHz: 8.83 ms");
}

TEST_CASE("latency sweep: the JSON has the law, the shortest good setting and null where nothing is known",
          "[latency]") {
  const auto json = json_of(swept());
  CHECK(json["settings"].size() == 7);
  CHECK(json["settings"][0]["refused"] == "blocks of 16 frames cannot be had");
  CHECK(json["settings"][1]["delay_frames"].is_null());
  CHECK(json["settings"][1]["verdict"] == "LOST_FRAMES");
  CHECK(json["settings"][2]["good"] == false);
  CHECK(json["settings"][5]["measured_already"] == true);
  REQUIRE(json["laws"].size() == 1);
  CHECK(json["laws"][0]["settings"] == 3);
  CHECK(json["laws"][0]["fixed_frames"].get<double>() == Approx(40));
  CHECK(json["laws"][0]["per_frame"].get<double>() == Approx(3));
  CHECK(json["shortest"]["block_frames"] == 128);
  CHECK(json["shortest"]["delay_ms"].get<double>() == Approx(424 / 48.0));
}

TEST_CASE("latency sweep: the picture marks what lost frames, and is well-formed", "[latency]") {
  const auto svg = to_svg({picture_of(swept())});
  CHECK(test::well_formed(svg));
  for (const char* words :
       {"32: LOST_FRAMES", "lost frames", "block [frames]", "delay [ms]", "48 kHz, 2 periods"})
    contains(svg, words);
}

TEST_CASE("latency report: a high-pass is a value, a bound or not measured", "[latency]") {
  Analysis analysis = cable();
  analysis.fitted_from_hz = 150;
  analysis.high_pass_hz = 8;
  analysis.high_pass_error_hz = 0.02;
  REQUIRE(highpass_of(analysis).corner);
  CHECK(highpass_of(analysis).corner->value == 8);
  // 1 / (2 pi 8 Hz)
  contains(highpass_text(analysis), "8.00 ± 0.02 Hz");
  contains(highpass_text(analysis), "19.89 ms");
  analysis.high_pass_hz = 0.05;
  CHECK_FALSE(highpass_of(analysis).corner);
  REQUIRE(highpass_of(analysis).bound);
  CHECK(highpass_of(analysis).bound->value == Approx(0.05 + 4 * 0.02));
  analysis.high_pass_error_hz = 10;
  CHECK_FALSE(highpass_of(analysis).bound);
  contains(highpass_text(analysis), "not measured");
  analysis.high_pass_error_hz.reset();
  contains(highpass_text(analysis), "not measured");
}
