#include "latency/estimation/probe_damage.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/core/index.h"
#include "latency/estimation/loop_recording.h"
#include "latency/estimation/pilot_track.h"

namespace tactus {
namespace {

constexpr std::int64_t kBlock = 64;
constexpr std::int64_t kSamePlace = 128;  // frames
constexpr double kSame = 0.7;             // correlation of what two probes leave at the same place
constexpr double kFarMore = 16.0;         // power
constexpr double kTouched = 1e-3;         // of a probe's power, more than other probes leave unexplained
constexpr double kNoisier = 1.5;          // than other probes is one that something happened to
constexpr std::int64_t kWithin = 64;      // frames lost within a probe
constexpr double kExplains = 0.8;         // of what is left beyond noise
constexpr double kCertain = 25.0;         // log-likelihood

/// Frames of a probe that are not as expected.
struct Run {
  std::size_t probe = 0;
  std::int64_t from = 0, frames = 0;  ///< in its window
};

std::vector<double> rest_of(const ProbeInTime& probe) {
  auto rest = probe.captured;
  for (std::size_t n = 0; n < rest.size(); ++n) rest[n] -= probe.expected[n];
  return rest;
}

double power_of(std::span<const double> samples) { return product(samples, samples); }

/// `variance`: of a frame of this probe. What lasts longer is a gain that changes, or a path that no model
/// fits.
std::vector<Run> runs_of(std::size_t number, const ProbeInTime& probe, double variance,
                         std::int64_t longest) {
  const auto rest = rest_of(probe);
  const auto blocks = std::ssize(rest) / kBlock;
  double loudest = 0.0;
  for (std::int64_t block = 0; block < blocks; ++block)
    loudest = std::max(loudest, power_of(part_of(probe.expected, block * kBlock, (block + 1) * kBlock)));
  const auto broken = [&](std::int64_t block) {
    const double explained = power_of(part_of(probe.expected, block * kBlock, (block + 1) * kBlock));
    const double unexplained = power_of(part_of(rest, block * kBlock, (block + 1) * kBlock));
    return explained > 1e-4 * loudest && unexplained > 0.25 * explained &&
           unexplained > 36.0 * kBlock * variance;
  };
  std::vector<Run> runs;
  for (const auto begin : short_runs(blocks, longest / kBlock, broken)) {
    auto end = begin;
    while (end < blocks && broken(end)) ++end;
    runs.push_back({number, begin * kBlock, (end - begin) * kBlock});
  }
  return runs;
}

/// Do both leave the same there?
bool same(const ProbeInTime& a, const ProbeInTime& b, const Run& run) {
  const auto rest_a = rest_of(a), rest_b = rest_of(b);
  const auto part_a = part_of(rest_a, run.from, run.from + run.frames),
             part_b = part_of(rest_b, run.from, run.from + run.frames);
  return product(part_a, part_b) > kSame * std::sqrt(power_of(part_a) * power_of(part_b));
}

/// How often a signal changes its sign: about as many values of it are independent.
double crossings(std::span<const double> samples) {
  double count = 0.0;
  for (std::size_t n = 1; n < samples.size(); ++n) count += samples[n - 1] * samples[n] < 0.0;
  return std::max(1.0, count);
}

/// In the mean of all, what happened to one is left over by the others, too.
bool by_mean(const std::vector<ProbeInTime>& probes, const Run& run) {
  const auto power = [&](const ProbeInTime& probe) {
    const auto rest = rest_of(probe);
    return power_of(part_of(rest, run.from, run.from + run.frames));
  };
  const double here = power(probes[run.probe]);
  return std::any_of(probes.begin(), probes.end(),
                     [&](const ProbeInTime& probe) { return power(probe) > kFarMore * here; });
}

}  // namespace

ProbeDamage ProbeDamage::of(const std::vector<ProbeInTime>& probes, const std::vector<TrackedProbe>& tracked,
                            double variance, std::int64_t longest, bool ends) {
  const double misfit = usual(&TrackedProbe::misfit, tracked) + kTouched;
  const double chi_squared = kNoisier * usual(&TrackedProbe::chi_squared, tracked);
  ProbeDamage damage;
  std::vector<Run> runs;
  for (std::size_t n = 0; n < probes.size(); ++n) {
    const double gain = tracked[n].burst.gain;
    const auto found = runs_of(n, probes[n], variance / (gain * gain), longest);
    runs.insert(runs.end(), found.begin(), found.end());
    // Of a soft probe, noise is a larger share.
    const bool is_end = n == 0 || n + 1 == probes.size();
    if (!(ends && is_end && tracked[n].misfit > misfit && tracked[n].chi_squared > chi_squared)) continue;
    if (const auto step = step_within(probes[n], variance / (gain * gain))) damage.steps.push_back(*step);
  }
  for (const auto& run : runs) {
    const auto& probe = probes[run.probe];
    if (by_mean(probes, run)) continue;
    const bool again = std::any_of(runs.begin(), runs.end(), [&](const Run& other) {
      return other.probe != run.probe && std::abs(other.from - run.from) <= kSamePlace &&
             same(probe, probes[other.probe], run);
    });
    const auto expected = part_of(probe.expected, run.from, run.from + run.frames);
    const auto beside = Damage::of(part_of(probe.captured, run.from, run.from + run.frames), expected);
    if (again)
      damage.overdriven = true;
    else if (beside.replaced(crossings(expected)))
      damage.steps.push_back({probe.begin + run.from, 0.0});
  }
  return damage;
}

std::optional<DelayStep> step_within(const ProbeInTime& probe, double variance) {
  const auto size = std::ssize(probe.captured);
  // Of each place, how much of the expected signal is captured up to it, `lag` frames late.
  const auto matched = [&](std::int64_t lag) {
    std::vector<double> sums(index(size) + 1, 0.0);
    for (std::int64_t n = 0; n < size; ++n) {
      const auto there = n + lag;
      const double found = there >= 0 && there < size ? probe.captured[index(there)] : 0.0;
      sums[index(n) + 1] = sums[index(n)] + found * probe.expected[index(n)];
    }
    return sums;
  };
  const auto usual_delay = matched(0);
  double single = usual_delay.back(), best = 0.0;
  DelayStep step;
  for (std::int64_t lag = -kWithin; lag <= kWithin; ++lag) {
    if (lag == 0) continue;
    const auto other = matched(lag);
    single = std::max(single, other.back());
    for (std::size_t n = 0; n < other.size(); ++n) {
      const double moved = other[n] - usual_delay[n];
      const auto frame = probe.begin + static_cast<std::int64_t>(n);
      const double before = usual_delay.back() + moved, behind = other.back() - moved;
      if (before > best) step = {frame, static_cast<double>(-lag)}, best = before;
      if (behind > best) step = {frame, static_cast<double>(lag)}, best = behind;
    }
  }
  const double left = power_of(probe.captured) - 2.0 * single + power_of(probe.expected) -
                      variance * static_cast<double>(size);
  const double gained = best - single;
  if (2.0 * gained < kExplains * left || gained < kCertain * variance) return std::nullopt;
  return step;
}

}  // namespace tactus
