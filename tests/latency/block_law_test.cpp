#include "latency/block_law.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/dsp/generators/counter_noise.h"

using namespace tactus;

namespace {

SettingDelay setting(int block, double delay_frames) {
  SettingDelay setting;
  setting.block_frames = block;
  setting.delay_frames = delay_frames;
  setting.measured_s = 12;
  return setting;
}

SettingDelay bad(int block, Verdict verdict, const std::string& remedy = "") {
  auto bad = setting(block, 0);
  bad.finding = {verdict, "it was seen", remedy};
  return bad;
}

bool says(const std::vector<SettingDelay>& settings, const std::string& words) {
  const auto text = recommendation(settings);
  INFO(text);
  CHECK(text.find(words) != std::string::npos);
  return text.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("block law: an exact line gives its two numbers, and no residual", "[latency]") {
  std::vector<SettingDelay> settings;
  for (const int block : {16, 64, 256, 1024}) settings.push_back(setting(block, 43.25 + 3.0 * block));
  const auto law = fit_block_law(settings);
  REQUIRE(law);
  CHECK(law->fixed_frames == Approx(43.25));
  CHECK(law->per_frame == Approx(3.0));
  CHECK(law->residual_frames == Approx(0).epsilon(0).margin(1e-9));
  CHECK(law->at(512) == Approx(43.25 + 1536));
}

TEST_CASE("block law: residuals that lean on no line change nothing but the standard errors", "[latency]") {
  // (1, -3, 3, -1) has neither a mean nor a slope. Of the blocks: mean 250, sum of squares 50 000 around it.
  std::vector<SettingDelay> settings = {setting(100, 241), setting(200, 437), setting(300, 643),
                                        setting(400, 839)};
  const auto law = fit_block_law(settings);
  REQUIRE(law);
  CHECK(law->fixed_frames == Approx(40));
  CHECK(law->per_frame == Approx(2));
  CHECK(law->residual_frames == Approx(std::sqrt(20.0 / 2)));
  CHECK(*law->per_frame_standard_error == Approx(std::sqrt(10.0 / 50000)));
  CHECK(*law->fixed_standard_error == Approx(std::sqrt(10.0 * (0.25 + 250.0 * 250 / 50000))));
}

TEST_CASE("block law: over many trials the fits scatter as much as their standard errors say", "[latency]") {
  const CounterNoise noise{7, 0};
  constexpr int kTrials = 4000;
  double fixed = 0, slope = 0, said_fixed = 0, said_slope = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<SettingDelay> settings;
    for (const int block : {32, 64, 128, 256, 512})
      settings.push_back(
          setting(block, 50 + 2.0 * block + 0.5 * noise.gaussian(5 * trial + settings.size())));
    const auto law = fit_block_law(settings);
    REQUIRE(law);
    fixed += std::pow(law->fixed_frames - 50, 2) / kTrials;
    slope += std::pow(law->per_frame - 2, 2) / kTrials;
    said_fixed += std::pow(*law->fixed_standard_error, 2) / kTrials;
    said_slope += std::pow(*law->per_frame_standard_error, 2) / kTrials;
  }
  // A variance from 4000 trials is known to sqrt(2 / 4000) = 2.2 %, the mean of those said to sqrt(2 / 3 /
  // 4000) = 1.3 %: 10 % is four times both together.
  CHECK(fixed == Approx(said_fixed).epsilon(0.1));
  CHECK(slope == Approx(said_slope).epsilon(0.1));
}

TEST_CASE("block law: two blocks make a line without errors, one makes none", "[latency]") {
  const auto line = fit_block_law({setting(64, 200), setting(128, 330)});
  REQUIRE(line);
  CHECK(line->fixed_frames == Approx(70));
  CHECK_FALSE(line->per_frame_standard_error);
  CHECK_FALSE(fit_block_law({setting(64, 200), setting(64, 201)}));
  CHECK_FALSE(fit_block_law({setting(64, 200), bad(128, Verdict::LowSnr)}));
  CHECK_FALSE(fit_block_law({}));
}

TEST_CASE("block law: what lost frames or is not to be trusted is left out of the line", "[latency]") {
  auto gap = setting(16, 5000);
  gap.gaps = 1;
  const auto law = fit_block_law({gap, bad(32, Verdict::LostFrames), setting(64, 170), setting(128, 298)});
  REQUIRE(law);
  CHECK(law->settings == 2);
  CHECK(law->per_frame == Approx(2));
}

TEST_CASE("block law: the shortest is the shortest in time, not in frames", "[latency]") {
  auto fast = setting(64, 200);
  fast.sample_rate = 96_kHz;
  const std::vector<SettingDelay> settings = {setting(32, 150), fast, bad(16, Verdict::LostFrames)};
  REQUIRE(shortest_good(settings) != nullptr);
  CHECK(shortest_good(settings)->sample_rate == 96_kHz);
  CHECK(shortest_good({bad(16, Verdict::NoSignal)}) == nullptr);
}

TEST_CASE("block law: the recommendation names the setting, what was wrong below it and what is next",
          "[latency]") {
  auto gaps = setting(32, 110);
  gaps.gaps = 3;
  const std::vector<SettingDelay> settings = {bad(16, Verdict::LostFrames), gaps, setting(64, 192),
                                              setting(128, 384), setting(256, 768)};
  says(settings, "Play with 64 frames, 48 kHz: 4.00 ms, and no frame was lost in 12 s.");
  says(settings, "32 frames, 48 kHz had 3 gaps");
  says(settings, "use 128 frames, 48 kHz, which adds 4.00 ms");
}

TEST_CASE("block law: where nothing held, the recommendation says what to mend", "[latency]") {
  says({bad(16, Verdict::NoSignal, "connect the cable")}, "(NO_SIGNAL): connect the cable");
  auto gap = setting(64, 100);
  gap.gaps = 1;
  says({gap}, "No setting ran without a gap");
  says({}, "Nothing was measured");
}
