#include "tests/studies/stroke/vary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::study {
namespace {

constexpr double kRate = 48000, kTurn = 2 * std::numbers::pi / kRate;

double gain(double db) { return std::pow(10.0, db / 20); }

double between(Random& random, double low, double high) { return low + (high - low) * random.uniform(); }

double log_between(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

/// About normal, at a quarter of the time.
double noise(Random& random) {
  return std::sqrt(3.0) * (random.uniform() + random.uniform() + random.uniform() + random.uniform() - 2);
}

double one_pole(double cutoff_hz) { return 1 - std::exp(-kTurn * cutoff_hz); }

/// Played `ratio` times as fast: cubic interpolation (Catmull & Rom).
std::vector<float> played(const std::vector<float>& in, double ratio) {
  std::vector<float> out(static_cast<std::size_t>(static_cast<double>(in.size()) / ratio));
  for (std::size_t n = 0; n < out.size(); ++n) {
    const double place = static_cast<double>(n) * ratio;
    const auto i = static_cast<std::size_t>(place);
    const auto t = static_cast<float>(place - static_cast<double>(i));
    const auto at = [&](std::size_t k) { return k < in.size() ? in[k] : 0.0f; };
    const float a = i > 0 ? in[i - 1] : 0.0f, b = at(i), c = at(i + 1), d = at(i + 2);
    out[n] = b + 0.5f * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
  }
  return out;
}

/// High frequencies by `db` more than low ones.
void tilt(std::vector<float>& hit, double corner_hz, double db) {
  const double feed = one_pole(corner_hz), high = gain(db / 2), low_gain = gain(-db / 2);
  double low = 0;
  for (float& x : hit) {
    low += feed * (static_cast<double>(x) - low);
    x = static_cast<float>(low_gain * low + high * (static_cast<double>(x) - low));
  }
}

/// Adds a mode that the hit excites.
void ring(std::vector<float>& hit, double frequency_hz, double fall_s, double level) {
  std::vector<float> in = hit;
  const double radius = std::exp(-1 / (fall_s * kRate)), turn = kTurn * frequency_hz;
  double y1 = 0, y2 = 0, highest = 1e-9;
  hit.resize(static_cast<std::size_t>(0.7 * kRate));
  std::vector<double> mode(hit.size());
  for (std::size_t n = 0; n < mode.size(); ++n) {
    const double x = n < in.size() ? static_cast<double>(in[n]) : 0;
    mode[n] = x + 2 * radius * std::cos(turn) * y1 - radius * radius * y2;
    y2 = y1, y1 = mode[n];
    highest = std::max(highest, std::abs(mode[n]));
  }
  const std::size_t fade = 960;
  for (std::size_t n = 0; n < mode.size(); ++n) {
    const double end = std::min(1.0, static_cast<double>(mode.size() - n) / fade);
    hit[n] += static_cast<float>(level / highest * end * mode[n]);
  }
}

void normalise(std::vector<float>& hit) {
  float highest = 1e-9f;
  for (float x : hit) highest = std::max(highest, std::abs(x));
  for (float& x : hit) x /= highest;
}

double onset_s(const std::vector<float>& hit) {
  std::size_t n = 0;
  while (n < hit.size() && std::abs(hit[n]) < 0.05f) ++n;
  return static_cast<double>(n) / kRate;
}

/// Noise that rises slowly after a stroke and falls again.
struct Rattle {
  double level = 0, top_s = 0, start = 0, fall_s = 0, low_hz = 0, high_hz = 0, roughness = 0, grain_s = 0;

  explicit Rattle(Random& random)
      : level(gain(between(random, -38, -10))),
        top_s(between(random, 0.020, 0.080)),
        start(gain(-between(random, 3, 9))),
        fall_s(log_between(random, 0.015, 0.12)),
        low_hz(log_between(random, 200, 3000)),
        high_hz(log_between(random, 3000, 16000)),
        roughness(between(random, 0, 6)),
        grain_s(log_between(random, 0.0005, 0.008)) {}

  void add(Random& random, std::vector<float>& audio, std::size_t onset, double scale) const {
    const double top = top_s * between(random, 0.8, 1.2), begin_s = 0.002;
    const double low_feed = one_pole(low_hz), high_feed = one_pole(high_hz);
    double low = 0, smooth = 0, grain = 1, to = 1, left = 0;
    const double peak = scale * level * gain(between(random, -3, 3));
    for (std::size_t n = 0; n < static_cast<std::size_t>((top + 5 * fall_s) * kRate); ++n) {
      if (onset + n >= audio.size()) return;
      if (left <= 0) {
        left = grain_s * kRate * between(random, 0.5, 1.5);
        to = gain(roughness * random.normal());
      }
      left -= 1;
      grain += 0.02 * (to - grain);
      const double time = static_cast<double>(n) / kRate;
      const double envelope =
          time < begin_s ? start * time / begin_s
          : time < top
              ? start + (1 - start) *
                            (0.5 - 0.5 * std::cos(std::numbers::pi * (time - begin_s) / (top - begin_s)))
              : std::exp(-(time - top) / fall_s);
      smooth += high_feed * (noise(random) - smooth);
      low += low_feed * (smooth - low);
      audio[onset + n] += static_cast<float>(peak * envelope * grain * (smooth - low));
    }
  }
};

void add_thump(Random& random, std::vector<float>& audio, double time_s, double level) {
  const double frequency_hz = between(random, 30, 120), rise_s = between(random, 0.004, 0.015);
  const double fall_s = between(random, 0.02, 0.1);
  for (std::size_t n = 0; n < static_cast<std::size_t>(5 * fall_s * kRate); ++n) {
    const auto place = static_cast<std::size_t>(time_s * kRate) + n;
    if (place >= audio.size()) return;
    const double time = static_cast<double>(n) / kRate;
    audio[place] += static_cast<float>(level * (1 - std::exp(-time / rise_s)) * std::exp(-time / fall_s) *
                                       std::sin(kTurn * frequency_hz * static_cast<double>(n)));
  }
}

void add_noise(Random& random, std::vector<float>& audio, double level, double cutoff_hz) {
  const double feed = one_pole(cutoff_hz), scale = level / std::sqrt(feed / (2 - feed));
  double low = 0;
  for (float& x : audio) {
    low += feed * (noise(random) - low);
    x += static_cast<float>(scale * low);
  }
}

void add_hum(Random& random, std::vector<float>& audio) {
  const double level = gain(between(random, -70, -34)), mains_hz = random.uniform() < 0.5 ? 50 : 60;
  const double second = random.uniform(), third = random.uniform(), fifth = random.uniform();
  for (std::size_t n = 0; n < audio.size(); ++n) {
    const double turn = kTurn * mains_hz * static_cast<double>(n);
    audio[n] += static_cast<float>(level * (std::sin(turn) + second * std::sin(2 * turn) +
                                            third * std::sin(3 * turn) + fifth * std::sin(5 * turn)));
  }
}

}  // namespace

void vary(Random& random, const std::vector<float>& first, const std::vector<float>& second, double take_s,
          std::vector<double>& strokes_s, std::vector<float>& audio) {
  const auto happens = [&](double probability) { return random.uniform() < probability; };
  std::vector<float> hits[2] = {first, second};
  if (happens(0.5)) {
    const double ratio = std::pow(2.0, between(random, -3, 3) / 12);
    for (auto& hit : hits) hit = played(hit, ratio);
  }
  if (happens(0.5)) {
    const double corner_hz = log_between(random, 300, 4000), db = between(random, -9, 9);
    for (auto& hit : hits) tilt(hit, corner_hz, db);
  }
  if (happens(0.3)) {
    const int modes = 1 + static_cast<int>(random.below(3));
    for (int mode = 0; mode < modes; ++mode) {
      const double frequency_hz = log_between(random, 90, 1500), fall_s = log_between(random, 0.03, 0.4);
      const double level = gain(between(random, -24, -4));
      for (auto& hit : hits) ring(hit, frequency_hz, fall_s, level);
    }
  }
  for (auto& hit : hits) normalise(hit);
  const double onsets_s[2] = {onset_s(hits[0]), onset_s(hits[1])};

  audio.assign(static_cast<std::size_t>(take_s * kRate), 0);
  const double rate = 5 * std::pow(6.0, random.uniform()), range_db = between(random, 3, 24);
  const double loudest = gain(happens(0.5) ? between(random, -6, 0) : between(random, -30, 0));
  const double irregular = happens(0.4) ? between(random, 0.1, 0.6) : 0.03;
  const double rest = happens(0.2) ? 0.08 : 0, thump = happens(0.2) ? 0.3 : 0,
               thump_level = gain(between(random, -26, -3));
  const bool rattles = happens(0.45);
  const Rattle rattle(random);
  std::size_t stroke = 0;
  for (double time = 0.3; time < take_s - 0.1; ++stroke) {
    const std::vector<float>& hit = hits[stroke % 2];
    const auto start = static_cast<std::size_t>(time * kRate);
    const double scale = loudest * gain(-range_db * random.uniform());
    for (std::size_t n = 0; n < hit.size() && start + n < audio.size(); ++n)
      audio[start + n] += static_cast<float>(scale) * hit[n];
    strokes_s.push_back(static_cast<double>(start) / kRate + onsets_s[stroke % 2]);
    if (rattles)
      rattle.add(random, audio, start + static_cast<std::size_t>(onsets_s[stroke % 2] * kRate), scale);
    if (happens(thump)) add_thump(random, audio, time + between(random, 0, 1 / rate), loudest * thump_level);
    time += std::max(0.015, (1 + irregular * (2 * random.uniform() - 1)) / rate);
    if (happens(rest)) time += between(random, 0.4, 1.5);
  }
  if (happens(0.2)) {
    const double drive = gain(between(random, 3, 15)) / loudest;
    for (float& x : audio) x = static_cast<float>(std::tanh(drive * static_cast<double>(x)) / drive);
  }
  add_noise(random, audio, gain(between(random, -72, -36)),
            happens(0.5) ? 40000 : log_between(random, 100, 20000));
  if (happens(0.3)) add_hum(random, audio);
}

}  // namespace tactus::study
