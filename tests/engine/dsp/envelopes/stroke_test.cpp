#include "engine/dsp/envelopes/stroke.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace tactus {
namespace {

using Samples = std::vector<double>;

Samples silence(double seconds, double rate) {
  return Samples(static_cast<std::size_t>(std::lround(seconds * rate)), 0.0);
}

/// Gaussian noise that all rates share: the mean of the samples of a fine grid would not be white.
void add_noise(Samples& to, double rms, unsigned seed = 1) {
  std::mt19937 bits(seed);
  const auto uniform = [&] { return (static_cast<double>(bits()) + 0.5) / 4294967296.0; };
  for (double& x : to)
    x += rms * std::sqrt(-2 * std::log(uniform())) * std::cos(2 * std::numbers::pi * uniform());
}

/// A drum: three partials that decay in 60 ms, from a rise of 0.2 ms.
void strike(Samples& to, double start_s, double height, double rate) {
  for (std::size_t n = static_cast<std::size_t>(std::ceil(start_s * rate)); n < to.size(); ++n) {
    const double t = static_cast<double>(n) / rate - start_s;
    double sum = 0;
    for (double f : {220.0, 530.0, 1250.0, 2600.0}) sum += std::cos(2 * std::numbers::pi * f * t);
    to[n] += height * 0.25 * sum * (1 - std::exp(-t / 0.0002)) * std::exp(-t / 0.03);
  }
}

/// A stroke every 150 ms, from 0.3 s on.
Samples roll(double rate, int strokes) {
  Samples in = silence(0.3 + 0.15 * strokes, rate);
  for (int i = 0; i < strokes; ++i) strike(in, 0.3 + 0.15 * i, i % 2 == 0 ? 0.5 : 0.2, rate);
  add_noise(in, 3e-4);
  return in;
}

struct Detected {
  std::vector<double> times_s;
  std::vector<double> levels;  ///< at the end of each stroke's first 10 ms
};

Detected detect(const Samples& in, double rate, const tactus_stroke_net& net, const Samples& reference = {},
                double threshold = 0) {
  tactus_stroke state{};
  tactus_stroke_start(&state, rate, &net);
  Detected detected;
  for (std::size_t n = 0; n < in.size(); ++n) {
    const double thrown = reference.empty() ? 0 : reference[n];
    if (tactus_stroke_step(&state, in[n], thrown, threshold, 0.010, !reference.empty()) != 0)
      detected.times_s.push_back(static_cast<double>(n) / rate);
  }
  detected.levels.push_back(state.level);
  return detected;
}

double decibels(double power) { return 10 * std::log10(power); }

}  // namespace

TEST_CASE("stroke: the level of a sine at the centre of a band is its power", "[dsp]") {
  // RBJ band-pass: 0 dB at its centre. The energy of a sine of amplitude a is a^2 / 2; a frame of 0.5 ms
  // holds whole half cycles of 3200 and 6400 Hz only nearly, so 0.5 dB are left for the rest. With a decay
  // of v in 0.5 ms the level is the higher of the frame's energy and 4.3 dB below the last one's.
  const double rate = GENERATE(44100.0, 48000.0, 96000.0, 192000.0);
  const int band = GENERATE(2, 3, 4, 5, 6);
  const double centre_hz[] = {90, 200, 400, 800, 1600, 3200, 6400};
  tactus_stroke state{};
  tactus_stroke_start(&state, rate, &tactus_stroke_nets[1]);
  double sum = 0;
  int frames = 0;
  for (int n = 0; n < static_cast<int>(0.3 * rate); ++n) {
    tactus_stroke_step(&state, 0.3 * std::sin(2 * std::numbers::pi * centre_hz[band] * n / rate), 0, 0, 0.01,
                       0);
    if (state.samples != 0 || state.frames < 200) continue;
    sum += state.loud[state.slot][band];
    ++frames;
  }
  CHECK(sum / frames == Approx(decibels(0.3 * 0.3 / 2)).margin(band < 4 ? 1.5 : 0.5));
}

TEST_CASE("stroke: what the net sees of a step of level, in closed form", "[dsp]") {
  // A sine at 1600 Hz whose amplitude becomes tenfold: 20 dB over all windows of the past, in the band
  // and, through the skirts, in all others as well; the windows r1, r2, r3 and the mean before it are equal.
  const double rate = 48000;
  const int k = tactus_stroke_nets[3].lookahead;  // 3 ms: the filters have settled in it
  tactus_stroke state{};
  tactus_stroke_start(&state, rate, &tactus_stroke_nets[3]);
  const int change = 24 * 400;
  for (int n = 0; n < change + 24 * k; ++n) {
    const double a = n < change ? 0.02 : 0.2;
    tactus_stroke_step(&state, a * std::sin(2 * std::numbers::pi * 2000 * n / rate), 0, 0, 0.01, 0);
  }
  REQUIRE(state.samples == 0);
  for (int band : {4, 5}) {  // whole cycles in a frame, and nothing left of the start
    CHECK(state.x[0][band] == Approx(2.0).margin(0.02));    // L - r1, in 10 dB
    CHECK(state.x[1][band] >= state.x[0][band]);            // recent - r1
    CHECK(state.x[5][band] == Approx(0.0).margin(0.002));   // r1 - r2
    CHECK(state.x[6][band] == Approx(0.0).margin(0.002));   // r2 - r3
    CHECK(state.x[7][band] == Approx(0.0).margin(0.002));   // m12 - mean
    CHECK(state.x[10][band] == Approx(0.0).margin(0.002));  // steepest rise of the past
  }
}

TEST_CASE("stroke: the windows are those of their definition", "[dsp]") {
  const int index = GENERATE(0, 1, 2, 3);
  const tactus_stroke_net& net = tactus_stroke_nets[index];
  const int k = net.lookahead;
  tactus_stroke state{};
  tactus_stroke_start(&state, 48000, &net);
  Samples in = roll(48000, 3);
  std::vector<std::vector<double>> loud, rise;  // [frame][band]
  std::vector<double> struck(TACTUS_STROKE_BANDS, -90.0);
  int since = 1000, strokes = 0;  // frames
  for (std::size_t n = 0; n < in.size(); ++n) {
    const int stroke = tactus_stroke_step(&state, in[n], 0, 0, 0.010, 0);
    if (state.samples != 0) continue;
    ++since;
    const double* levels = state.loud[state.slot];
    loud.emplace_back(levels, levels + TACTUS_STROKE_BANDS);
    rise.emplace_back(TACTUS_STROKE_BANDS, 0.0);
    if (loud.size() < 300) {
      for (std::size_t b = 0; b < TACTUS_STROKE_BANDS && loud.size() > 70; ++b) {
        double r1 = -1e9;
        for (int i = k; i <= k + 7; ++i)
          r1 = std::max(r1, loud[loud.size() - 1 - static_cast<std::size_t>(i)][b]);
        rise.back()[b] = loud.back()[b] - r1;
      }
      continue;
    }
    for (std::size_t b = 0; b < TACTUS_STROKE_BANDS; ++b) {
      const auto highest = [&](const auto& of, int from, int to) {
        double result = -1e9;
        for (int i = from; i <= to; ++i)
          result = std::max(result, of[of.size() - 1 - static_cast<std::size_t>(i)][b]);
        return result;
      };
      const double now = loud.back()[b], r1 = highest(loud, k, k + 7), r2 = highest(loud, k + 8, k + 23);
      const double r3 = highest(loud, k + 24, k + 55), recent = highest(loud, 0, k - 1);
      const double early = highest(loud, std::max(1, k / 2), k - 1), m12 = std::max(r1, r2);
      rise.back()[b] = now - r1;
      double mean = 0;
      for (int i = k; i < k + 24; ++i) mean += loud[loud.size() - 1 - static_cast<std::size_t>(i)][b] / 24;
      const double floor = state.floor_db[b];
      if (since <= 10) struck[b] = std::max(struck[b], now);
      const double expected[] = {now - r1,
                                 recent - r1,
                                 recent - m12,
                                 recent - std::max(m12, r3),
                                 early - r1,
                                 r1 - r2,
                                 r2 - r3,
                                 m12 - mean,
                                 r1 - floor,
                                 recent - floor,
                                 highest(rise, k + 2, k + 39),
                                 recent - struck[b]};
      if (stroke != 0) struck[b] = recent;
      for (int i = 0; i < TACTUS_STROKE_FEATURES; ++i) {
        const double number = std::clamp(expected[i], -25.0, 40.0) / 10;
        if (std::abs(state.x[i][b] - number) > 1e-9) FAIL("number " << i << " of band " << b);
      }
    }
    if (stroke != 0) {
      since = 0;
      ++strokes;
    } else if (strokes > 0) {
      const double times_s[] = {0.015, 0.060, 0.240};
      for (int i = 0; i < TACTUS_STROKE_AGES; ++i)
        if (std::abs(state.after[i] - std::exp(-since * TACTUS_STROKE_FRAME_S / times_s[i])) > 1e-9)
          FAIL("age " << i);
    }
  }
  CHECK(loud.size() > 1000);
  CHECK(strokes == 3);
}

TEST_CASE("stroke: the net is the plain sum of its definition", "[dsp]") {
  std::mt19937 bits(3);
  for (const tactus_stroke_net& net : tactus_stroke_nets) {
    tactus_real x[TACTUS_STROKE_FEATURES][TACTUS_STROKE_BANDS];
    for (auto& row : x)
      for (double& number : row) number = static_cast<double>(bits()) / 4294967296.0 * 6.5 - 2.5;
    tactus_real after[TACTUS_STROKE_AGES];
    for (double& number : after) number = static_cast<double>(bits()) / 4294967296.0;
    const auto q = [](long double s) { return s > 0 ? s : 0.05L * s; };
    auto z = static_cast<long double>(net.last_bias);
    for (int m = 0; m < TACTUS_STROKE_JOINT; ++m) {
      auto g = static_cast<long double>(net.joint_bias[m]);
      for (int i = 0; i < TACTUS_STROKE_AGES; ++i)
        g += static_cast<long double>(after[i]) * static_cast<long double>(net.age[i][m]);
      for (int b = 0; b < TACTUS_STROKE_BANDS; ++b)
        for (int j = 0; j < TACTUS_STROKE_HIDDEN; ++j) {
          auto h = static_cast<long double>(net.band_bias[j][b]);
          for (int i = 0; i < TACTUS_STROKE_FEATURES; ++i)
            h += static_cast<long double>(x[i][b]) * static_cast<long double>(net.band[i][j]);
          g += q(h) * static_cast<long double>(net.joint[b * TACTUS_STROKE_HIDDEN + j][m]);
        }
      z += q(g) * static_cast<long double>(net.last[m]);
    }
    CHECK(tactus_stroke_judge(&net, x, after) == Approx(static_cast<double>(z)).epsilon(1e-12));
  }
}

TEST_CASE("stroke: the vectorised form gives the bits of the kernel", "[dsp]") {
  const Samples in = roll(44100, 3), thrown = roll(44100, 3);
  const bool referenced = GENERATE(false, true);
  tactus_stroke one{}, many{};
  tactus_stroke_start(&one, 44100, &tactus_stroke_nets[2]);
  many = one;
  int strokes = 0;
  for (std::size_t n = 0; n < in.size();) {
    const int count = tactus_stroke_samples_left(&many, static_cast<int>(in.size() - n));
    const int last = follow_stroke(many, &in[n], referenced ? &thrown[n] : nullptr, count, 0, 0.010);
    for (int i = 0; i < count; ++i, ++n) {
      const int stroke = tactus_stroke_step(&one, in[n], thrown[n], 0, 0.010, referenced);
      if (stroke != (i == count - 1 ? last : 0)) FAIL("frame " << n);
    }
    if (one.evidence != many.evidence || one.level != many.level) FAIL("frame " << n);
    strokes += last;
  }
  CHECK(strokes == (referenced ? 0 : 3));  // a reference that is the signal masks all of it
}

TEST_CASE("stroke: each stroke of a plain roll once, within its lookahead and two frames", "[dsp]") {
  const int index = GENERATE(0, 1, 2, 3);
  const tactus_stroke_net& net = tactus_stroke_nets[index];
  const auto detected = detect(roll(48000, 8), 48000, net).times_s;
  REQUIRE(detected.size() == 8);
  for (std::size_t i = 0; i < 8; ++i) {
    const double late_s = detected[i] - (0.3 + 0.15 * static_cast<double>(i));
    CHECK(late_s >= 0);
    CHECK(late_s < (net.lookahead + 1) * TACTUS_STROKE_FRAME_S + 0.0005);
  }
}

TEST_CASE("stroke: the decisions of all sample rates agree to two frames", "[dsp]") {
  const auto expected = detect(roll(48000, 8), 48000, tactus_stroke_nets[1]).times_s;
  const double rate = GENERATE(8000.0, 11025.0, 16000.0, 22050.0, 44100.0, 88200.0, 96000.0, 192000.0);
  INFO(rate);
  const auto detected = detect(roll(rate, 8), rate, tactus_stroke_nets[1]).times_s;
  REQUIRE(detected.size() == expected.size());
  for (std::size_t i = 0; i < detected.size(); ++i)
    CHECK(detected[i] == Approx(expected[i]).margin(2 * TACTUS_STROKE_FRAME_S));
}

TEST_CASE("stroke: a frame is 0.5 ms at every sample rate", "[dsp]") {
  const double rate = GENERATE(8000.0, 11025.0, 44100.0, 48000.0, 192000.0);
  tactus_stroke state{};
  tactus_stroke_start(&state, rate, &tactus_stroke_nets[1]);
  int frames = 0;
  for (int n = 0; n < static_cast<int>(10 * rate); ++n) {
    tactus_stroke_step(&state, 0, 0, 0, 0.01, 0);
    frames += state.samples == 0;
  }
  CHECK(frames == Approx(20000).margin(1));
}

TEST_CASE("stroke: level is the stroke's peak, threshold the level of the softest", "[dsp]") {
  Samples in = silence(0.5, 48000);
  strike(in, 0.3, 0.5, 48000);
  double peak = 0;
  for (double x : in) peak = std::max(peak, std::abs(x));
  add_noise(in, 1e-4);
  // A high-pass at 30 Hz takes what a wave that starts at its crest has of lower frequencies.
  CHECK(detect(in, 48000, tactus_stroke_nets[1]).levels[0] == Approx(peak).epsilon(0.1));
  CHECK(detect(in, 48000, tactus_stroke_nets[1], {}, 0.5 * peak).times_s.size() == 1);
  CHECK(detect(in, 48000, tactus_stroke_nets[1], {}, 1.1 * peak).times_s.empty());
}

TEST_CASE("stroke: noise and what is not finite are no strokes", "[dsp]") {
  Samples in = silence(20, 48000);
  add_noise(in, 0.01, 7);
  in[100000] = std::numeric_limits<double>::quiet_NaN();
  in[200000] = std::numeric_limits<double>::infinity();
  CHECK(detect(in, 48000, tactus_stroke_nets[1]).times_s.empty());
}

TEST_CASE("stroke: a reference masks its own sound, and no stroke beside it", "[dsp]") {
  // Throws of 10 ms of a 150 Hz wave, 12 a second, which the microphone picks up 3 ms later at a tenth;
  // strokes lie between them.
  const double rate = 48000;
  Samples thrown = silence(4, rate), in = silence(4, rate);
  std::vector<double> strokes_s;
  for (double start_s = 0.5; start_s < 3.9; start_s += 1.0 / 12) {
    for (int n = 0; n < static_cast<int>(0.010 * rate); ++n)
      thrown[static_cast<std::size_t>(start_s * rate) + static_cast<std::size_t>(n)] =
          std::sin(2 * std::numbers::pi * 150 * n / rate);
    if (start_s > 2) {
      strokes_s.push_back(start_s + 0.05);
      strike(in, strokes_s.back(), 0.1, rate);
    }
  }
  for (std::size_t n = 144; n < in.size(); ++n) in[n] += 0.1 * thrown[n - 144];
  add_noise(in, 1e-4);
  const tactus_stroke_net& net = tactus_stroke_nets[1];
  const auto masked = detect(in, rate, net, thrown).times_s;
  CHECK(detect(in, rate, net).times_s.size() > strokes_s.size() + 10);
  REQUIRE(masked.size() == strokes_s.size());
  for (std::size_t i = 0; i < masked.size(); ++i)
    CHECK(masked[i] == Approx(strokes_s[i] + 0.001).margin(0.002));
}

}  // namespace tactus
