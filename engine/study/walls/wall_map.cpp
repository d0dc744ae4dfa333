#include "engine/study/walls/wall_map.h"

#include <algorithm>
#include <cmath>

#include "engine/core/find_root.h"
#include "engine/study/sweep/parallel_for.h"
#include "engine/study/walls/wall_border.h"

namespace tactus {
namespace {

constexpr double kAside = 0.02;  // how far from a border it is confirmed
constexpr double kShortest_s = 20e-6, kLongest_s = 40e-3;
constexpr double kSlowest_Hz = 250, kFastest_Hz = 192e3;
constexpr double kStart_m = 1e-3;  // any: the loop is linear
constexpr double kCounts = 12;  // from which an encoder's wall starts: many steps, not yet the motor's limit
constexpr double kPatience_frames = 2e6;

std::vector<double> spread(double low, double high, int per_decade) {
  const int steps = static_cast<int>(std::ceil(std::log10(high / low) * per_decade));
  std::vector<double> values;
  for (int i = 0; i <= steps; ++i)
    values.push_back(low * std::pow(high / low, static_cast<double>(i) / steps));
  return values;
}

WallLimit limit_of(const WallDevice& device, const WallLoop& loop) {
  WallLimit limit{.loop = loop};
  const auto border = wall_border(device, loop);
  limit.stiffest = border.stiffness;
  limit.formula = stiffest_by_damping(device, loop);
  limit.passive = stiffest_passive(device, loop);
  limit.cycle = border.frequency;
  if (border.stiffness <= 0) return limit;
  // The border is that of the linear loop, so a linear simulation confirms it.
  WallRun run{.device = {.mass = device.mass, .damping = device.damping}, .loop = loop};
  const auto trend_at = [&](double part) {
    run.stiffness = part * border.stiffness;
    return trend_of(WallSimulation{run, kStart_m, 0}, border.frequency, loop.rate);
  };
  limit.below = trend_at(1 - kAside);
  limit.above = trend_at(1 + kAside);
  return limit;
}

/// The stiffness at which a start of some counts no longer dies, as the simulation finds it.
double border_with_steps(const WallDevice& device, const WallLimit& limit, int bits) {
  WallRun run{.device = device, .loop = limit.loop, .bits = bits};
  run.device.friction = 0;
  return root_between(
      0.5 * limit.stiffest, 2 * limit.stiffest,
      [&](double stiffness) {
        run.stiffness = stiffness;
        const WallSimulation simulation{run, kCounts * device.quantum, 0};
        return trend_of(simulation, limit.cycle, limit.loop.rate, kPatience_frames) == LoopTrend::Decays
                   ? -1.0
                   : 1.0;
      },
      1e-4);
}

std::optional<FixedPoint> fixed_point_of(const WallDevice& device, const WallLimit& limit, int bits) {
  const bool counted = bits > 0 && device.quantum > 0 && std::isfinite(device.force_limit);
  if (!counted || limit.stiffest <= 0) return std::nullopt;
  FixedPoint fixed{};
  fixed.force_step = std::ldexp(device.force_limit, 1 - bits);
  fixed.stiffness_step = fixed.force_step / device.quantum;
  fixed.full_depth = device.force_limit / limit.stiffest;
  fixed.with_encoder = border_with_steps(device, limit, 0);
  fixed.with_bits = border_with_steps(device, limit, bits);
  return fixed;
}

/// A place on the map that is still empty.
struct Job {
  const WallDevice* device;
  WallLoop loop;
  WallLimit* limit;
};

class Mapping {
 public:
  explicit Mapping(const WallStudy& study) : study_(study) {
    map_.devices = study.devices;
    map_.rate = study.rate;
    map_.friction_limit = stiffest_by_friction(study.devices.front().device);
    for (const auto& controller : study.controllers) map_.controllers.push_back({controller, {}, {}});
    for (auto& controller : map_.controllers) controller.limits.resize(study.devices.size());
    map_.by_delay.resize(study.devices.size());
    map_.by_rate.resize(study.devices.size());
  }

  WallMap run(const std::function<void(double)>& progress) {
    for (std::size_t d = 0; d < study_.devices.size(); ++d) plan(d);
    parallel_for(
        static_cast<int>(jobs_.size()),
        [&](int i) {
          const auto& job = jobs_[static_cast<std::size_t>(i)];
          *job.limit = limit_of(*job.device, job.loop);
        },
        [&](double share) {
          if (progress) progress(share);
        });
    for (auto& [controller, limits, fixed] : map_.controllers)
      fixed = fixed_point_of(study_.devices.front().device, limits.front(), controller.bits);
    return std::move(map_);
  }

 private:
  void plan(std::size_t d) {
    const auto delays = spread(kShortest_s, kLongest_s, study_.points_per_decade);
    const auto rates = spread(kSlowest_Hz, kFastest_Hz, study_.points_per_decade);
    auto &by_delay = map_.by_delay[d], &by_rate = map_.by_rate[d];
    by_delay.resize(delays.size());
    by_rate.resize(rates.size());
    for (std::size_t i = 0; i < delays.size(); ++i) add(d, {study_.rate, Seconds{delays[i]}}, by_delay[i]);
    for (std::size_t i = 0; i < rates.size(); ++i)
      add(d, {Hertz{rates[i]}, Seconds{1 / rates[i]}}, by_rate[i]);
    for (auto& [controller, limits, fixed] : map_.controllers)
      add(d, {controller.rate, controller.delay}, limits[d]);
  }
  void add(std::size_t device, WallLoop loop, WallLimit& limit) {
    loop.damping = study_.damping;
    jobs_.push_back({&study_.devices[device].device, loop, &limit});
  }

  const WallStudy& study_;
  WallMap map_;
  std::vector<Job> jobs_;
};

template <class Count>
int sum_over(const WallMap& map, const Count& count) {
  int sum = 0;
  for (const auto* curves : {&map.by_delay, &map.by_rate})
    for (const auto& curve : *curves)
      sum += static_cast<int>(std::count_if(curve.begin(), curve.end(), count));
  for (const auto& controller : map.controllers)
    sum += static_cast<int>(std::count_if(controller.limits.begin(), controller.limits.end(), count));
  return sum;
}

}  // namespace

std::vector<WallController> controllers_of_the_paper() {
  return {{"ATMEL", 20_kHz, Seconds{50e-6}, 16},
          {"DIMPLE", 1_kHz, 1_ms},
          {"TFCS", 40_kHz, Seconds{20e-6}},
          {"ASP", 96_kHz, 10_ms},
          {"best ASP", 96_kHz, 4_ms},
          {"Cellomobo", 44.1_kHz, 20_ms}};
}

int WallMap::borders() const {
  return sum_over(*this, [](const WallLimit& limit) { return limit.stiffest > 0; });
}
int WallMap::confirmed() const {
  return sum_over(*this, [](const WallLimit& limit) { return limit.stiffest > 0 && limit.confirmed(); });
}

WallMap map_walls(const WallStudy& study, const std::function<void(double)>& progress) {
  return Mapping{study}.run(progress);
}

}  // namespace tactus
