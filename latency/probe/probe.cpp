#include "latency/probe/probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "latency/estimation/loop_recording.h"

namespace tactus {
namespace {

using std::numbers::pi;

constexpr double kHighest = 0.42;    // of the sample rate: below where converters' filters begin
constexpr Seconds kRise{0.008};      // of the first edge; the last one lasts an eighth of it
constexpr Seconds kProbeQuiet{0.5};  // from the beginning of a stimulus to its first probe
constexpr Seconds kProbePilot{0.5}, kPilotEdge{0.002};
constexpr Seconds kMark{0.03}, kMarkEdge{0.0003};
constexpr Seconds kLongestMark{0.034};          // a probe for the level lasts 40 ms
constexpr std::uint64_t kMarkNoise = 1u << 20;  // behind the pilot's at any rate
// No two stretches of pauses are equally long, so a train fits itself only where it is.
constexpr std::array kPauses{0.100, 0.116, 0.104, 0.124, 0.108, 0.132, 0.112, 0.140};

/// 0 to 1 and back over [0, length), along half a period of a cosine each.
double edges(double at, double length, double rise, double fall) {
  const auto raised = [](double x) { return x >= 1.0 ? 1.0 : 0.5 - 0.5 * std::cos(pi * x); };
  return raised(at / rise) * raised((length - at) / fall);
}

/// A number in [-1, 1) for each n, by a hash (splitmix64).
double even_noise(std::uint64_t n) {
  auto x = (n + 1) * 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-52 - 1.0;
}

void append(std::vector<double>& to, const std::vector<double>& from, double gain) {
  for (const double sample : from) to.push_back(gain * sample);
}

// ---- bursts

constexpr Seconds kPause{0.02};
constexpr Seconds kBurstsPilot{0.25};
constexpr double kBurstsSilence = 3e-3;      // of the peak: dither and noise of converters lie below
constexpr std::int64_t kBurstsSearch = 256;  // frames that may be hidden at the soft beginning of a burst
constexpr double kAlike = 0.99, kSame = 1.0 - 1e-9;

std::vector<Burst> between_pauses(std::span<const double> played, std::int64_t pause) {
  const double silence = kBurstsSilence * peak_of(played);
  std::vector<Burst> bursts;
  for (std::size_t n = 0; n < played.size(); ++n) {
    if (!(std::abs(played[n]) > silence)) continue;
    const auto at = static_cast<std::int64_t>(n);
    if (bursts.empty() || at - bursts.back().end() >= pause) bursts.push_back({at, 0, 1.0});
    bursts.back().frames = at + 1 - bursts.back().at;
  }
  return bursts;
}

/// Of `burst`, placed so that `waveform` fits it best; nothing if it is another one.
std::optional<Burst> as_repetition(std::span<const double> played, const Burst& burst,
                                   std::span<const double> waveform) {
  const auto length = static_cast<std::int64_t>(waveform.size());
  if (std::abs(burst.frames - length) > kBurstsSearch) return std::nullopt;
  std::optional<Burst> best;
  double highest = kAlike;
  // 0, 1, -1, 2, …: mostly the first fits to the last bit.
  for (std::int64_t k = 0; k <= 2 * kBurstsSearch && highest < kSame; ++k) {
    const auto at = burst.at + (k % 2 == 0 ? -k / 2 : (k + 1) / 2);
    if (at < 0 || at + length > static_cast<std::int64_t>(played.size())) continue;
    const auto section = played.subspan(index(at), waveform.size());
    const double common = product(section, waveform);
    const double alike = common * common / (product(section, section) * product(waveform, waveform));
    if (!(alike > highest)) continue;
    highest = alike;
    best = Burst{at, length, common / product(waveform, waveform)};
  }
  return best;
}

struct Group {
  std::vector<double> waveform;
  std::vector<Burst> bursts;
  double energy() const {
    double sum = 0.0;
    for (const auto& burst : bursts) sum += burst.gain * burst.gain;
    return sum * product(waveform, waveform);
  }
};

std::vector<Group> grouped(std::span<const double> played, std::vector<Burst> bursts) {
  const auto loudness = [&](const Burst& burst) {
    return peak_of(played.subspan(index(burst.at), index(burst.frames)));
  };
  std::stable_sort(bursts.begin(), bursts.end(),
                   [&](const Burst& a, const Burst& b) { return loudness(a) > loudness(b); });
  std::vector<Group> groups;
  for (const auto& burst : bursts) {
    std::optional<Burst> repetition;
    for (auto& group : groups) {
      repetition = as_repetition(played, burst, group.waveform);
      if (repetition) group.bursts.push_back(*repetition);
      if (repetition) break;
    }
    if (repetition) continue;
    const auto waveform = played.subspan(index(burst.at), index(burst.frames));
    groups.push_back({{waveform.begin(), waveform.end()}, {burst}});
  }
  return groups;
}

bool is_main(const Group& a, const Group& b) {
  const bool repeated_a = a.bursts.size() > 1, repeated_b = b.bursts.size() > 1;
  return repeated_a != repeated_b ? repeated_a : a.energy() > b.energy();
}

}  // namespace

std::size_t whole_frames(Seconds time, Hertz sample_rate) {
  return static_cast<std::size_t>(std::llround(frames_in(time, sample_rate)));
}

Seconds ExponentialSweep::growth() const { return duration / std::log(stop / start); }

std::vector<double> ExponentialSweep::samples(Hertz sample_rate) const {
  const double length = frames_in(duration, sample_rate);
  const double growth_s = growth().value;
  std::vector<double> samples(whole_frames(duration, sample_rate));
  const double rise = frames_in(kRise, sample_rate);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double at = static_cast<double>(n);
    const double phase = 2 * pi * start.value * growth_s * std::expm1(at / sample_rate.value / growth_s);
    samples[n] = std::sin(phase) * edges(at, length, rise, rise / 8);
  }
  return samples;
}

ExponentialSweep measuring_probe(Hertz sample_rate) { return {20_Hz, sample_rate * kHighest, Seconds{0.35}}; }

ExponentialSweep level_probe(Hertz sample_rate) { return {100_Hz, sample_rate * kHighest, Seconds{0.04}}; }

std::vector<double> pilot(Hertz sample_rate) {
  std::vector<double> samples(whole_frames(kProbePilot, sample_rate));
  const double edge = frames_in(kPilotEdge, sample_rate), length = frames_in(kProbePilot, sample_rate);
  // Nothing at half the sample rate, where a fraction of a frame of delay has no meaning.
  for (std::size_t n = 0; n < samples.size(); ++n)
    samples[n] = (0.25 * even_noise(n) + 0.5 * even_noise(n + 1) + 0.25 * even_noise(n + 2)) *
                 edges(static_cast<double>(n), length, edge, edge);
  return samples;
}

std::vector<double> mark(Hertz sample_rate) {
  std::vector<double> samples(whole_frames(kMark, sample_rate));
  const double edge = frames_in(kMarkEdge, sample_rate), length = frames_in(kMark, sample_rate);
  const auto sign = [](std::uint64_t n) { return even_noise(kMarkNoise + n) < 0.0 ? -1.0 : 1.0; };
  for (std::size_t n = 0; n < samples.size(); ++n)
    samples[n] = (0.25 * sign(n) + 0.5 * sign(n + 1) + 0.25 * sign(n + 2)) *
                 edges(static_cast<double>(n) + 0.5, length, edge, edge);
  return samples;
}

double ProbeTrain::gain(int probe) { return probe % 4 == 1 ? kSoftGain : 1.0; }

std::vector<double> ProbeTrain::samples(Hertz sample_rate, int count, double level, Seconds lead) {
  std::vector<double> train;
  append(train, mark(sample_rate), level);
  train.resize(whole_frames(lead, sample_rate), 0.0);
  const auto probe = measuring_probe(sample_rate).samples(sample_rate);
  for (int k = 0; k < count; ++k) {
    append(train, probe, level * gain(k));
    train.resize(train.size() + whole_frames(Seconds{kPauses[index(k) % kPauses.size()]}, sample_rate), 0.0);
  }
  append(train, pilot(sample_rate), level);
  return train;
}

std::vector<double> stimulus(Hertz sample_rate, double level) {
  return ProbeTrain::samples(sample_rate, ProbeTrain::kProbes, level, kProbeQuiet);
}

std::optional<Burst> PlayedBursts::pilot(Hertz sample_rate) const {
  std::optional<Burst> longest;
  for (const auto& burst : others)
    if (static_cast<double>(burst.frames) >= frames_in(kBurstsPilot, sample_rate) &&
        (!longest || burst.frames > longest->frames))
      longest = burst;
  return longest;
}

std::optional<Burst> PlayedBursts::mark(Hertz sample_rate) const {
  std::optional<Burst> last;
  for (const auto& burst : others)
    if (burst.at < repeated.front().at) last = burst;
  const bool is_short = last && static_cast<double>(last->frames) <= frames_in(kLongestMark, sample_rate);
  return is_short ? last : std::nullopt;
}

bool repeats(std::span<const double> samples, std::span<const double> waveform) {
  // With room before and behind, for what is missing at the soft beginning.
  std::vector<double> roomy(index(kBurstsSearch), 0.0);
  roomy.insert(roomy.end(), samples.begin(), samples.end());
  roomy.resize(roomy.size() + 2 * kBurstsSearch, 0.0);
  return as_repetition(roomy, {kBurstsSearch, static_cast<std::int64_t>(samples.size()), 1.0}, waveform)
      .has_value();
}

std::optional<PlayedBursts> find_bursts(std::span<const double> played, Hertz sample_rate) {
  const auto bursts = between_pauses(played, std::llround(frames_in(kPause, sample_rate)));
  if (bursts.empty()) return std::nullopt;
  auto groups = grouped(played, bursts);
  std::stable_sort(groups.begin(), groups.end(), is_main);

  const auto by_time = [](const Burst& a, const Burst& b) { return a.at < b.at; };
  PlayedBursts found;
  found.waveform = std::move(groups.front().waveform);
  found.peak = peak_of(found.waveform);
  found.repeated = std::move(groups.front().bursts);
  std::sort(found.repeated.begin(), found.repeated.end(), by_time);
  for (std::size_t g = 1; g < groups.size(); ++g)
    found.others.insert(found.others.end(), groups[g].bursts.begin(), groups[g].bursts.end());
  std::sort(found.others.begin(), found.others.end(), by_time);

  found.pause = static_cast<std::int64_t>(played.size());
  for (const auto& burst : found.repeated)
    for (const auto& other : bursts)
      if (other.at > burst.end() - kBurstsSearch) found.pause = std::min(found.pause, other.at - burst.end());
  return found;
}

}  // namespace tactus
