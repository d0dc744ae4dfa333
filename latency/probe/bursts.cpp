#include "latency/probe/bursts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "latency/estimation/loop_recording.h"

namespace tactus {
namespace {

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

std::optional<Burst> PlayedBursts::pilot(Hertz sample_rate) const {
  std::optional<Burst> longest;
  for (const auto& burst : others)
    if (static_cast<double>(burst.frames) >= frames_in(kBurstsPilot, sample_rate) &&
        (!longest || burst.frames > longest->frames))
      longest = burst;
  return longest;
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
