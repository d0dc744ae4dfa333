
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::play_node;
using test::refusal;
using test::Samples;

namespace {

constexpr double kTwoPi = 6.283185307179586;

/// A WAV file of 16-bit samples that goes when the object goes.
class WavFile {
 public:
  WavFile(const std::string& name, std::uint32_t rate, std::uint16_t channels,
          const std::vector<std::int16_t>& samples)
      : path_((std::filesystem::temp_directory_path() / name).string()) {
    const auto bytes = static_cast<std::uint32_t>(2 * samples.size());
    file_.open(path_, std::ios::binary);
    file_ << "RIFF", number<std::uint32_t>(36 + bytes), file_ << "WAVEfmt ", number<std::uint32_t>(16);
    number<std::uint16_t>(1), number(channels), number(rate), number<std::uint32_t>(rate * channels * 2);
    number<std::uint16_t>(static_cast<std::uint16_t>(2 * channels)), number<std::uint16_t>(16);
    file_ << "data", number(bytes);
    for (const auto sample : samples) number(static_cast<std::uint16_t>(sample));
    file_.close();
  }
  ~WavFile() { std::remove(path_.c_str()); }
  WavFile(const WavFile&) = delete;
  WavFile& operator=(const WavFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  template <class Unsigned>
  void number(Unsigned value) {
    for (std::size_t i = 0; i < sizeof value; ++i) file_.put(static_cast<char>((value >> (8 * i)) & 0xff));
  }
  std::string path_;
  std::ofstream file_;
};

}  // namespace

TEST_CASE("sine: level sin(2 pi f t + phase)", "[nodes]") {
  const auto out =
      play_node(test::node_type("sine"), 48001, {{"frequency", 440.0}, {"phase", 0.5}, {"level", 2.0}});
  for (const std::size_t n : {0u, 1u, 100u, 48000u})
    CHECK(out[n] == Approx(2 * std::sin(kTwoPi * 440 * static_cast<double>(n) / 48000 + 0.5)).margin(1e-10));
}

TEST_CASE("sine: a frequency that glides keeps the phase continuous", "[nodes]") {
  Samples frequency(4800);
  for (std::size_t n = 0; n < frequency.size(); ++n) frequency[n] = static_cast<double>(n);  // f = 48000 t
  const auto out = play_node(test::node_type("sine"), 4800, {{"frequency", frequency}});
  // Phase in turns: the sum of n / 48000 below 4799.
  CHECK(out[4799] == Approx(std::sin(kTwoPi * 4799.0 * 4798.0 / 2 / 48000)).margin(1e-9));
}

TEST_CASE("noise: seeds differ, runs do not", "[nodes]") {
  const auto first = play_node(test::node_type("noise"), 100, {});
  CHECK(play_node(test::node_type("noise"), 100, {}) == first);
  CHECK(play_node(test::node_type("noise"), 100, {}, {{"seed", "2"}}) != first);
}

TEST_CASE("noise: level is the peak of the uniform and the deviation of the gaussian one", "[nodes]") {
  const auto uniform = play_node(test::node_type("noise"), 48000, {{"level", 2.0}});
  const auto gaussian =
      play_node(test::node_type("noise"), 48000, {{"level", 2.0}}, {{"distribution", "gaussian"}});
  const auto power = [](const Samples& x) {
    return std::inner_product(x.begin(), x.end(), x.begin(), 0.0) / 48000;
  };
  // Five standard deviations of the estimate.
  CHECK(power(uniform) == Approx(4.0 / 3).margin(5 * 4 * std::sqrt(4.0 / 45 / 48000)));
  CHECK(power(gaussian) == Approx(4.0).margin(5 * 4 * std::sqrt(2.0 / 48000)));
  CHECK(*std::max_element(uniform.begin(), uniform.end()) < 2);
}

TEST_CASE("wavetable: repeats its numbers, and backwards at negative frequency", "[nodes]") {
  const std::map<std::string, std::string> table = {{"table", "[0, 1, 0.5, -1]"}};
  CHECK(play_node(test::node_type("wavetable"), 6, {{"frequency", 12000.0}}, table) ==
        Samples{0, 1, 0.5, -1, 0, 1});
  CHECK(play_node(test::node_type("wavetable"), 6, {{"frequency", -12000.0}}, table) ==
        Samples{0, -1, 0.5, 1, 0, -1});
}

TEST_CASE("wavetable: an empty table is refused", "[nodes]") {
  CHECK(refusal(test::node_type("wavetable"), {{"frequency", 1.0}}) == "BadArgument 'table' table 0 1 0 -1");
}

#if defined(TACTUS_HAS_SNDFILE)
TEST_CASE("sample: plays the chosen channel from each trigger", "[nodes]") {
  const WavFile file("tactus_sample_test.wav", 48000, 2, {16384, 1, -8192, 2, 4096, 3});
  Samples trigger(12, 0.0);
  trigger[2] = trigger[7] = 1;
  const auto play = [&](const std::string& channel) {
    return play_node(test::node_type("sample"), 12, {{"trigger", trigger}, {"level", 2.0}},
                     {{"file", file.path()}, {"channel", channel}});
  };
  CHECK(play("1") == Samples{0, 0, 1, -0.5, 0.25, 0, 0, 1, -0.5, 0.25, 0, 0});
  CHECK(play("2")[3] == 2 * 2.0 / 32768);
}

TEST_CASE("sample: sounds at its own pitch whatever the engine's rate", "[nodes]") {
  std::vector<std::int16_t> sine;
  for (int n = 0; n < 2000; ++n)
    sine.push_back(static_cast<std::int16_t>(std::lround(16000 * std::sin(kTwoPi * 100 * n / 8000))));
  const WavFile file("tactus_sample_rate_test.wav", 8000, 1, sine);
  const auto out = play_node(test::node_type("sample"), 1000, {{"trigger", 1.0}}, {{"file", file.path()}});
  double worst = 0;
  // Before its first sample the file is silent, which the cubic there notices: one sample of the file is 6
  // frames.
  for (int n = 6; n < 1000; ++n)
    worst = std::max(worst, std::abs(out[static_cast<std::size_t>(n)] -
                                     16000.0 / 32768 * std::sin(kTwoPi * 100 * n / 48000)));
  // Catmull-Rom on a sine of 80 samples: slopes are short by (2 pi / 80)^2 / 6, which costs less than a
  // thirteenth of that times 2 pi / 80; and half a step of 16 bits, vectorised by the cubic to at most 5 / 4.
  CHECK(worst < 0.49 * std::pow(kTwoPi / 80, 3) / 6 / 4 + 0.5 / 32768 * 1.25);
}

TEST_CASE("sample: says which file it cannot read, and which channel is not there", "[nodes]") {
  const auto missing = refusal(test::node_type("sample"), {{"trigger", 0.0}}, {{"file", "/no/such.wav"}});
  CHECK(missing == "BadFile '/no/such.wav'");
  const WavFile file("tactus_sample_channel_test.wav", 48000, 1, {1, 2});
  const auto channel =
      refusal(test::node_type("sample"), {{"trigger", 0.0}}, {{"file", file.path()}, {"channel", "2"}});
  CHECK(channel == "OutOfRange '" + file.path() + "' 1 2 'channel'");
}
#endif

TEST_CASE("curve: each point stands in its own frame, and the last one holds", "[nodes]") {
  const auto out = play_node(test::node_type("curve"), 200, {},
                             {{"points", "[[0, 1], [\"3 ms\", 2], [\"3.3 ms\", 5]]"}, {"curve", "step"}});
  CHECK(out[143] == 1);
  CHECK(out[144] == 2);
  CHECK(out[158] == 2);  // 3.3 ms is frame 158.4
  CHECK(out[159] == 5);
  CHECK(out[199] == 5);
}

TEST_CASE("curve: a time that a rounding error moved off its frame is put back", "[nodes]") {
  // 1e-15 s late is 5e-11 of a frame.
  const auto out = play_node(test::node_type("curve"), 200, {},
                             {{"points", "[[0, 1], [0.003000000000001, 2]]"}, {"curve", "step"}});
  CHECK(out[143] == 1);
  CHECK(out[144] == 2);
}

TEST_CASE("curve: linear and smooth ways between two points", "[nodes]") {
  const std::string points = "[[0, 0], [0.01, 8]]";
  CHECK(play_node(test::node_type("curve"), 480, {}, {{"points", points}})[120] == 2);
  const double u = 0.25;  // level at both ends: 3 u^2 - 2 u^3
  CHECK(play_node(test::node_type("curve"), 480, {}, {{"points", points}, {"curve", "smooth"}})[120] ==
        Approx(8 * (3 * u * u - 2 * u * u * u)).epsilon(1e-14));
}

TEST_CASE("curve: with a trigger it waits, runs, and starts over", "[nodes]") {
  Samples trigger(60, 0.0);
  trigger[10] = trigger[30] = 1;
  const auto out =
      play_node(test::node_type("curve"), 60, {{"trigger", trigger}}, {{"points", "[[0, 3], [0.001, 51]]"}});
  CHECK(out[9] == 3);
  CHECK(out[10] == 3);
  CHECK(out[29] == 22);
  CHECK(out[30] == 3);
  CHECK(out[40] == 13);
}

TEST_CASE("curve: speed and level are those of the frame in which it starts", "[nodes]") {
  Samples trigger(20, 0.0), speed(20, 1.0), level(20, 1.0);
  trigger[0] = trigger[10] = 1;
  speed[0] = 2, level[0] = 3;
  speed[10] = 0.5, level[10] = -1;
  const auto out =
      play_node(test::node_type("curve"), 20, {{"trigger", trigger}, {"speed", speed}, {"level", level}},
                {{"points", "[[0, 0], [0.001, 48]]"}});
  CHECK(out[4] == 3 * 8);
  CHECK(out[9] == 3 * 18);
  CHECK(out[10] == 0);
  CHECK(out[14] == -2);
}
