#include "latency/path/second_path.h"

#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "engine/core/decibels.h"
#include "engine/core/median.h"

namespace tactus {
namespace {

constexpr double kSoftest = 0.01;  // of the path: it moves no delay by a thousandth of a frame
constexpr double kAside = 2.0;

/// How much of what the path brings of a burst stands in `rest` at the delay `frames`, beside the path.
double usual_level(const LoopEstimate& loop, std::span<const double> first, std::span<const double> rest,
                   std::int64_t frames) {
  std::vector<double> levels;
  for (const auto& burst : loop.probe.bursts.repeated) {
    const auto whole = stretch(first, burst.at + loop.path.at, burst.end() + loop.path.at);
    const auto again = stretch(rest, burst.at + frames, burst.end() + frames);
    const bool recorded = again.size() == whole.size();
    levels.push_back(recorded ? std::abs(product(again, whole)) / product(whole, whole) : 0.0);
  }
  return median(std::move(levels));
}

}  // namespace

std::optional<SecondPath> find_second_path(const LoopEstimate& loop, CoarseSearch& search) {
  if (!loop.clock.coarse.clear()) return std::nullopt;
  auto model = loop.path.fit.model;
  model.delay_frames = loop.constant();
  const auto first = search.behind(model);
  std::vector<double> rest = loop.clock.samples;
  for (std::size_t n = 0; n < rest.size(); ++n) rest[n] -= loop.probe.floor.mean + first[n];
  if (product(rest, rest) < kSoftest * kSoftest * product(first, first)) return std::nullopt;

  const auto found = search.find(rest);
  SecondPath second;
  second.frames = found.frames - std::llround(loop.constant());
  if (!found.clear() || std::abs(second.frames) <= SecondPath::kNear) return std::nullopt;
  const double level = usual_level(loop, first, rest, found.frames);
  // A gain that moves leaves something at the path itself, which may look alike sweeps later.
  if (level < kSoftest || level < kAside * usual_level(loop, first, rest, loop.path.at)) return std::nullopt;
  second.level_db = amplitude_to_db(level);
  return second;
}

}  // namespace tactus
