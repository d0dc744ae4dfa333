#include "engine/study/walls/wall_map.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/core/find_root.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/plan/fingerprint.h"

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

/// Border and frequency, then the trends below and above it.
std::vector<double> border_run(const WallDevice& device, const WallLoop& loop) {
  const auto border = wall_border(device, loop);
  std::vector<double> numbers{border.stiffness, border.frequency.value};
  // The border is that of the linear loop, so a linear simulation confirms it.
  WallRun run{.device = {.mass = device.mass, .damping = device.damping}, .loop = loop};
  for (const double side : {1 - kAside, 1 + kAside}) {
    run.stiffness = side * border.stiffness;
    numbers.push_back(static_cast<double>(
        border.stiffness > 0 ? trend_of(WallSimulation{run, kStart_m, 0}, border.frequency, loop.rate)
                             : LoopTrend::Undecided));
  }
  return numbers;
}

void set_limit(WallLimit& limit, const WallDevice& device, const std::vector<double>& numbers) {
  limit.stiffest = numbers[0];
  limit.formula = stiffest_by_damping(device, limit.loop);
  limit.passive = stiffest_passive(device, limit.loop);
  limit.cycle = Hertz{numbers[1]};
  limit.below = static_cast<LoopTrend>(numbers[2]);
  limit.above = static_cast<LoopTrend>(numbers[3]);
}

/// Smallest stiffness at which an oscillation of some counts no longer decays in the simulation.
double border_with_steps(const WallDevice& device, const WallLimit& limit, int bits) {
  WallRun run{.device = device, .loop = limit.loop, .bits = bits};
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

/// All points of the study, not computed yet.
WallMap empty_map(const WallStudy& study) {
  WallMap map{study};
  std::vector<WallLimit> by_delay, by_rate;
  for (const double delay : spread(kShortest_s, kLongest_s, study.points_per_decade))
    by_delay.push_back({.loop = {study.rate, Seconds{delay}, study.damping}});
  for (const double rate : spread(kSlowest_Hz, kFastest_Hz, study.points_per_decade))
    by_rate.push_back({.loop = {Hertz{rate}, Seconds{1 / rate}, study.damping}});
  map.by_delay.assign(study.devices.size(), by_delay);
  map.by_rate.assign(study.devices.size(), by_rate);
  for (auto& controller : map.controllers)
    controller.limits.assign(study.devices.size(),
                             {.loop = {controller.rate, controller.delay, study.damping}});
  map.friction_limit = stiffest_by_friction(study.devices.front().device);
  return map;
}

template <class Map, class Visit>
void for_each_limit(Map& map, const Visit& visit) {
  for (std::size_t d = 0; d < map.devices.size(); ++d) {
    for (auto* curves : {&map.by_delay, &map.by_rate})
      for (auto& limit : (*curves)[d]) visit(map.devices[d].device, limit);
    for (auto& controller : map.controllers) visit(map.devices[d].device, controller.limits[d]);
  }
}

std::uint64_t cache_key(const WallDevice& device, const WallLoop& loop) {
  Fingerprint print;
  for (const double number : {device.mass, device.damping, loop.rate.value, loop.delay.value, loop.damping})
    print.add(number);
  return print.add("wall").value();
}

/// The value of the control with a role, if there is one. Whether there is.
Result<bool> read_role(const SceneSpec& scene, const char* role, double& value) {
  const auto control = control_of(scene, role);
  if (!control) return false;
  const auto number = control->constant();
  if (!number)
    return fail(Errc::WrongType, find(control->part->wires, control->spec->name)->at.text(),
                "'" + control->name() + "' must be a number with a unit for this study",
                "give it one value, with the unit of the control");
  value = *number;
  return true;
}

}  // namespace

Result<SceneDevice> device_of(const SceneSpec& scene) {
  SceneDevice device;
  for (const auto& quantity : kDeviceQuantities) {
    const auto read = read_role(scene, quantity.role, device.bare.*quantity.value);
    if (!read) return tl::unexpected(read.error());
    if (!*read && (quantity.value == &WallDevice::mass || quantity.value == &WallDevice::damping))
      return fail(
          Errc::Missing, scene.file.text(), fmt::format("no control has the role '{}'", quantity.role),
          "give one under [roles], or the device with --device-mass and --device-damping instead of a scene");
  }
  for (const auto& [role, value] :
       {std::pair{"hand_mass", &device.hand.mass}, {"hand_damping", &device.hand.damping}})
    if (const auto read = read_role(scene, role, *value); !read) return tl::unexpected(read.error());
  return device;
}

std::vector<WallController> controllers_of_the_paper() {
  return {{"ATMEL", 20_kHz, Seconds{50e-6}, 16},
          {"DIMPLE", 1_kHz, 1_ms},
          {"TFCS", 40_kHz, Seconds{20e-6}},
          {"ASP", 96_kHz, 10_ms},
          {"best ASP", 96_kHz, 4_ms},
          {"Cellomobo", 44.1_kHz, 20_ms}};
}

Checked<WallMap> map_walls(const WallStudy& study, const RunPlan& plan) {
  auto map = empty_map(study);
  std::vector<std::pair<const WallDevice*, WallLimit*>> points;
  for_each_limit(map, [&](const auto& device, auto& limit) { points.emplace_back(&device, &limit); });
  const auto point = [&](int i) { return points[static_cast<std::size_t>(i)]; };
  const auto results = evaluate_runs(
      plan, static_cast<int>(points.size()),
      [&](int i) { return cache_key(*point(i).first, point(i).second->loop); },
      [&](int i) -> Checked<std::vector<double>> {
        return border_run(*point(i).first, point(i).second->loop);
      });
  if (!results) return tl::unexpected(results.error());
  map.runs = std::ssize(points);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const auto& numbers = (*results)[i]; numbers && numbers->size() == 4) {
      set_limit(*points[i].second, *points[i].first, *numbers);
      ++map.finished;
      map.borders += points[i].second->stiffest > 0;
      map.confirmed += points[i].second->stiffest > 0 && points[i].second->confirmed();
    }
  for (auto& controller : map.controllers)
    controller.fixed_point =
        fixed_point_of(study.devices.front().device, controller.limits.front(), controller.bits);
  return map;
}

}  // namespace tactus
