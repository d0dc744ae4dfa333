#include "tests/studies/latency/backgrounds.h"

#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::study {
namespace {

namespace fs = std::filesystem;
using std::numbers::pi;
using Random = std::mt19937_64;

constexpr double kRate = 48000.0;

double between(Random& random, double low, double high) {
  return std::uniform_real_distribution{low, high}(random);
}

std::size_t one_of(Random& random, std::size_t count) {
  return std::uniform_int_distribution<std::size_t>{0, count - 1}(random);
}

/// The first channel; at most 20 s of it.
std::vector<float> read(const fs::path& file) {
  SF_INFO info{};
  SNDFILE* sound = sf_open(file.c_str(), SFM_READ, &info);
  if (sound == nullptr) return {};
  const auto frames = std::min<sf_count_t>(info.frames, 20 * info.samplerate);
  std::vector<float> all(static_cast<std::size_t>(frames * info.channels));
  const auto read = sf_readf_float(sound, all.data(), frames);
  sf_close(sound);
  std::vector<float> first(static_cast<std::size_t>(std::max<sf_count_t>(0, read)));
  for (std::size_t n = 0; n < first.size(); ++n) first[n] = all[n * static_cast<std::size_t>(info.channels)];
  return first;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(folder, none))
    if (const auto kind = entry.path().extension(); kind == ".flac" || kind == ".wav" || kind == ".oga")
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Adds `sound` from the frame `at` on; `again`: over and over.
void add(std::vector<double>& to, const std::vector<float>& sound, std::size_t at, double gain, bool again) {
  for (std::size_t n = at; n < to.size() && (again || n - at < sound.size()); ++n)
    to[n] += gain * static_cast<double>(sound[(n - at) % sound.size()]);
}

/// From a place within it on, over and over.
void add_loop(std::vector<double>& to, const std::vector<float>& sound, Random& random) {
  auto turned = sound;
  std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(one_of(random, sound.size())),
              turned.end());
  add(to, turned, 0, between(random, 0.3, 1.0), true);
}

void add_hits(std::vector<double>& to, const std::vector<std::vector<float>>& hits, Random& random) {
  const double every = kRate / between(random, 1.0, 8.0);
  for (double at = between(random, 0.0, every); at < static_cast<double>(to.size());
       at += every * between(random, 0.5, 1.5))
    add(to, hits[one_of(random, hits.size())], static_cast<std::size_t>(at), between(random, 0.2, 1.0),
        false);
}

void low_pass(std::vector<double>& samples, double hertz) {
  const double share = 1.0 - std::exp(-2.0 * pi * hertz / kRate);
  double state = 0.0;
  for (auto& sample : samples) sample = state += share * (sample - state);
}

/// A motor with its harmonics at a speed that wavers, the air that it moves, and now and then a knock.
std::vector<double> machine(std::size_t frames, Random& random) {
  std::normal_distribution<double> normal;
  std::vector<double> air(frames), samples(frames, 0.0);
  for (auto& sample : air) sample = normal(random);
  low_pass(air, between(random, 100.0, 8000.0));
  double power = 0.0;
  for (const double sample : air) power += sample * sample / static_cast<double>(frames);
  const double turns = between(random, 8.0, 120.0), waver = between(random, 0.0, 0.05);
  const double beat = between(random, 0.1, 12.0), depth = between(random, 0.0, 1.0);
  const double tones = between(random, 0.0, 2.0), falls = between(random, 0.3, 2.0);
  std::vector<double> phases(24), levels(24);
  for (std::size_t k = 0; k < phases.size(); ++k) {
    phases[k] = between(random, 0.0, 2.0 * pi);
    levels[k] = tones * between(random, 0.2, 1.0) * std::pow(static_cast<double>(k + 1), -falls);
  }
  double phase = 0.0;
  for (std::size_t n = 0; n < frames; ++n) {
    const double t = static_cast<double>(n) / kRate;
    phase += 2.0 * pi * turns / kRate * (1.0 + waver * std::sin(2.0 * pi * 0.7 * t));
    const double swell = 1.0 + depth * std::sin(2.0 * pi * beat * t);
    samples[n] = swell * air[n] / std::sqrt(power);
    for (std::size_t k = 0; k < phases.size(); ++k)
      samples[n] += levels[k] * std::sin(static_cast<double>(k + 1) * phase + phases[k]);
  }
  const bool knocks = between(random, 0.0, 1.0) < 0.5;
  const double ring = between(random, 200.0, 3000.0);
  for (double at = between(random, 0.0, 0.5); knocks && at * kRate < static_cast<double>(frames);
       at += between(random, 0.1, 1.0)) {
    const double loud = between(random, 1.0, 12.0);
    const auto begin = static_cast<std::size_t>(at * kRate);
    for (std::size_t n = begin; n < std::min(frames, begin + 4800); ++n) {
      const double t = static_cast<double>(n - begin) / kRate;
      samples[n] += loud * std::exp(-60.0 * t) * std::sin(2.0 * pi * ring * t);
    }
  }
  return samples;
}

/// White to brown.
std::vector<double> noise(std::size_t frames, Random& random) {
  std::normal_distribution<double> normal;
  std::vector<double> samples(frames);
  for (auto& sample : samples) sample = normal(random);
  if (one_of(random, 2) == 0) low_pass(samples, between(random, 50.0, 10000.0));
  return samples;
}

}  // namespace

Backgrounds::Backgrounds(Part part, const fs::path& speech) {
  const auto take = [&](const fs::path& folder, std::size_t least, std::size_t most) {
    std::vector<std::vector<float>> sounds;
    const auto files = files_in(folder);
    for (std::size_t n = part == Part::Chosen ? 0 : 1; n < files.size(); n += 2)
      if (auto sound = read(files[n]); sound.size() >= least && sound.size() <= most)
        sounds.push_back(std::move(sound));
    return sounds;
  };
  constexpr std::size_t kLong = 24000, kNoLimit = 1u << 30;
  long_ = take("/usr/share/sonic-pi/samples", kLong, kNoLimit);
  for (const char* folder :
       {"/usr/share/sonic-pi/samples", "/usr/share/hydrogen/data/drumkits", "/usr/share/sounds"})
    for (auto& hit : take(folder, 200, 4 * kLong)) hits_.push_back(std::move(hit));
  speech_ = take(speech, kLong, kNoLimit);
}

std::vector<double> Backgrounds::raw(Background kind, std::size_t frames, Random& random) const {
  if (kind == Background::Noise) return noise(frames, random);
  if (kind == Background::Machine) return machine(frames, random);
  std::vector<double> samples(frames, 0.0);
  if (kind == Background::Speech) {
    add_loop(samples, speech_[one_of(random, speech_.size())], random);
    return samples;
  }
  const auto loops = one_of(random, 4);  // 0: hits alone
  for (std::size_t n = 0; n < loops; ++n) add_loop(samples, long_[one_of(random, long_.size())], random);
  if (loops == 0 || one_of(random, 2) == 0) add_hits(samples, hits_, random);
  return samples;
}

std::vector<double> Backgrounds::samples(Background kind, std::size_t frames, Random& random) const {
  while (true) {
    auto samples = raw(kind, frames, random);
    double power = 0.0;
    for (const double sample : samples) power += sample * sample / static_cast<double>(frames);
    if (!(power > 1e-8)) continue;  // a silent stretch
    for (auto& sample : samples) sample /= std::sqrt(power);
    return samples;
  }
}

}  // namespace tactus::study
