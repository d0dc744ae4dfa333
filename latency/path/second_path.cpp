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
double usual_level(const LoopEstimator& path, std::span<const double> first, std::span<const double> rest,
                   std::int64_t frames) {
  std::vector<double> levels;
  for (const auto& burst : path.bursts.repeated) {
    const auto whole = stretch(first, burst.at + path.at, burst.end() + path.at);
    const auto again = stretch(rest, burst.at + frames, burst.end() + frames);
    const bool recorded = again.size() == whole.size();
    levels.push_back(recorded ? std::abs(product(again, whole)) / product(whole, whole) : 0.0);
  }
  return median(std::move(levels));
}

}  // namespace

std::optional<SecondPath> find_second_path(LoopEstimator& path) {
  if (!path.coarse.clear()) return std::nullopt;
  auto model = path.fitted.model;
  model.delay_frames = path.constant();
  const auto first = path.search().behind(model);
  std::vector<double> rest(path.steady_heard.begin(), path.steady_heard.end());
  for (std::size_t n = 0; n < rest.size(); ++n) rest[n] -= path.floor.mean + first[n];
  if (product(rest, rest) < kSoftest * kSoftest * product(first, first)) return std::nullopt;

  const auto found = path.search().find(rest);
  SecondPath second;
  second.frames = found.frames - std::llround(path.constant());
  if (!found.clear() || std::abs(second.frames) <= SecondPath::kNear) return std::nullopt;
  const double level = usual_level(path, first, rest, found.frames);
  // A gain that moves leaves something at the path itself, which may look alike sweeps later.
  if (level < kSoftest || level < kAside * usual_level(path, first, rest, path.at)) return std::nullopt;
  second.level_db = amplitude_to_db(level);
  return second;
}

}  // namespace tactus
