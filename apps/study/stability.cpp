#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>

#include "apps/study/study.h"

namespace tactus::app {
namespace {

using Curves = std::vector<std::vector<WallLimit>>;
using Abscissa = std::function<double(const WallLimit&)>;

/// Every so many points of a curve are enough for a table.
constexpr std::size_t kRows = 4;

std::string hz(Hertz rate) {
  return rate.value < 1000 ? fmt::format("{:.3g} Hz", rate.value)
                           : fmt::format("{:.4g} kHz", 1e-3 * rate.value);
}
std::string ms(Seconds time) { return fmt::format("{:.3g} ms", 1e3 * time.value); }
std::string n_per_m(double stiffness) {
  if (!std::isfinite(stiffness)) return "no limit";
  return stiffness < 1e4 ? fmt::format("{:.4g} N/m", stiffness)
                         : fmt::format("{:.4g} kN/m", 1e-3 * stiffness);
}

std::string describe(const MappedDevice& mapped) {
  const auto& device = mapped.device;
  auto text = fmt::format("  {:<14}{:g} g, {:g} N s/m", mapped.name, 1e3 * device.mass, device.damping);
  if (device.friction > 0) text += fmt::format(", dry friction {:g} N", device.friction);
  if (device.quantum > 0) text += fmt::format(", encoder steps of {:.4g} mm", 1e3 * device.quantum);
  if (std::isfinite(device.force_limit)) text += fmt::format(", force up to {:g} N", device.force_limit);
  return text + "\n";
}

/// A row of limits, one for each device, and what is passive for the first.
std::vector<std::string> row_of(const std::string& name, const std::vector<WallLimit>& limits) {
  std::vector<std::string> row{name};
  for (const auto& limit : limits) row.push_back(n_per_m(limit.stiffest));
  row.push_back(n_per_m(limits.front().passive));
  return row;
}

Table table_of(const WallMap& map, const std::string& what) {
  Table table{{{what}}};
  for (const auto& mapped : map.devices) table.rows[0].push_back(mapped.name);
  table.rows[0].push_back(map.devices.front().name + ", passive");
  return table;
}

std::string curve_text(const WallMap& map, const Curves& curves, const std::string& what,
                       const std::function<std::string(const WallLimit&)>& name) {
  auto table = table_of(map, what);
  const auto last = curves.front().size() - 1;
  for (std::size_t i = 0; i <= last; i = i == last ? last + 1 : std::min(last, i + kRows)) {
    std::vector<WallLimit> limits;
    for (const auto& curve : curves) limits.push_back(curve[i]);
    table.rows.push_back(row_of(name(limits.front()), limits));
  }
  return "\n" + table.text();
}

std::string controllers_text(const WallMap& map) {
  auto table = table_of(map, "controllers");
  for (const auto& controller : map.controllers)
    table.rows.push_back(
        row_of(fmt::format("{} {} {}", controller.name, hz(controller.rate), ms(controller.delay)),
               controller.limits));
  return "\n" + table.text();
}

std::string fixed_point_text(const WallController& controller) {
  if (!controller.fixed_point) return {};
  const auto& fixed = *controller.fixed_point;
  return fmt::format(
      "  {} computes with {} bits: force in steps of {:.3g} mN, stiffness in steps of {}; the motor's limit "
      "is reached\n  {:.2g} mm deep. In the simulation the stability limit is {} with the encoder alone, {} "
      "with the bits as well.\n",
      controller.name, controller.bits, 1e3 * fixed.force_step, n_per_m(fixed.stiffness_step),
      1e3 * fixed.full_depth, n_per_m(fixed.with_encoder), n_per_m(fixed.with_bits));
}

/// Empty if the position has no steps.
std::string friction_text(double limit) {
  if (!std::isfinite(limit)) return {};
  if (limit > 0) return fmt::format("\nDry friction suppresses encoder noise up to {}.\n", n_per_m(limit));
  return "\nWithout dry friction every wall oscillates between the steps of the encoder.\n";
}

const char* name_of(LoopTrend trend) {
  return trend == LoopTrend::Decays ? "decays" : trend == LoopTrend::Grows ? "grows" : "undecided";
}

Json part_json(const WallLimit& limit) {
  return {{"rate_hz", limit.loop.rate.value},   {"delay_s", limit.loop.delay.value},
          {"stiffest_n_per_m", limit.stiffest}, {"by_formula_n_per_m", limit.formula},
          {"passive_n_per_m", limit.passive},   {"cycle_hz", limit.cycle.value},
          {"at_0.98", name_of(limit.below)},    {"at_1.02", name_of(limit.above)}};
}

Json part_json(const std::vector<WallLimit>& limits) {
  return list_of(limits, [](const WallLimit& limit) { return part_json(limit); });
}

Json part_json(const WallController& controller, const std::vector<MappedDevice>& devices) {
  Json json{{"name", controller.name}, {"limits", Json::object()}};
  for (std::size_t d = 0; d < devices.size(); ++d)
    json["limits"][devices[d].name] = part_json(controller.limits[d]);
  if (const auto& fixed = controller.fixed_point)
    json["fixed_point"] = {{"bits", controller.bits},
                           {"force_step_n", fixed->force_step},
                           {"stiffness_step_n_per_m", fixed->stiffness_step},
                           {"full_depth_m", fixed->full_depth},
                           {"border_with_encoder_n_per_m", fixed->with_encoder},
                           {"border_with_bits_n_per_m", fixed->with_bits}};
  return json;
}

PlotSeries series_of(const std::string& label, const std::vector<WallLimit>& limits, const Abscissa& x,
                     double WallLimit::*y) {
  PlotSeries series{.label = label};
  for (const auto& limit : limits) {
    series.add(x(limit), limit.*y);
  }
  return series;
}

Plot plot_of(const WallMap& map, const Curves& curves, const Abscissa& x, PlotAxis axis) {
  Subplot plot;
  plot.y = {.label = "stiffest wall", .unit = "N/m", .log = true};
  for (std::size_t d = 0; d < curves.size(); ++d)
    plot.series.push_back(series_of(map.devices[d].name, curves[d], x, &WallLimit::stiffest));
  if (curves.size() > 2) {
    auto low = plot.series[1], high = plot.series.back();
    plot.regions.push_back({"held by a finger, lightly to firmly", low.x, low.y, high.y, PlotColor::Green});
  }
  const auto bare = plot.series.front();
  plot.regions.push_back({map.devices.front().name + ": stable", bare.x, {}, bare.y, PlotColor::Blue});
  auto passive = series_of(map.devices.front().name + ", passive", curves.front(), x, &WallLimit::passive);
  passive.dashed = true;
  passive.color = PlotColor::Grey;
  plot.series.push_back(std::move(passive));
  if (map.friction_limit > 0 && std::isfinite(map.friction_limit))
    plot.series.push_back({.label = "below: friction suppresses encoder noise",
                           .x = {bare.x.front(), bare.x.back()},
                           .y = {map.friction_limit, map.friction_limit},
                           .color = PlotColor::Black,
                           .dashed = true});
  for (const auto& controller : map.controllers)
    plot.pins.push_back(
        {x(controller.limits.front()), controller.limits.front().stiffest,
         controller.name + (controller.bits > 0 ? fmt::format(", {} bit", controller.bits) : ""),
         PlotColor::Black});
  axis.log = true;
  return {.x = std::move(axis), .subplots = {std::move(plot)}, .subplot_height = 420};
}

}  // namespace

std::string text_of(const WallMap& map) {
  std::string text = "Stiffest stable wall\n";
  for (const auto& mapped : map.devices) text += describe(mapped);
  text += curve_text(map, map.by_delay, "delay, at " + hz(map.rate),
                     [](const WallLimit& limit) { return ms(limit.loop.delay); });
  text += curve_text(map, map.by_rate, "rate, one frame of delay",
                     [](const WallLimit& limit) { return hz(limit.loop.rate); });
  text += controllers_text(map);
  for (const auto& controller : map.controllers) text += fixed_point_text(controller);
  return text + friction_text(map.friction_limit) +
         fmt::format(
             "\n{} of {} stability limits confirmed: at 0.98 of each the simulation decays, at 1.02 it "
             "grows.\n",
             map.confirmed, map.borders);
}

Json json_of(const WallMap& map) {
  Json json{{"devices", Json::array()},
            {"by_delay", Json::object()},
            {"by_rate", Json::object()},
            {"controllers", list_of(map.controllers, [&](const WallController& controller) {
               return part_json(controller, map.devices);
             })}};
  for (std::size_t d = 0; d < map.devices.size(); ++d) {
    const auto& [name, device] = map.devices[d];
    auto& entry = json["devices"].emplace_back(Json{{"name", name}});
    for (const auto& quantity : kDeviceQuantities) entry[quantity.key] = device.*quantity.value;
    json["by_delay"][name] = part_json(map.by_delay[d]);
    json["by_rate"][name] = part_json(map.by_rate[d]);
  }
  json["friction_limit_n_per_m"] = map.friction_limit;
  json["borders"] = map.borders;
  json["confirmed"] = map.confirmed;
  return json;
}

std::vector<Plot> plots_of(const WallMap& map) {
  auto by_delay = plot_of(map, map.by_delay, [](const WallLimit& limit) { return limit.loop.delay.value; },
                          {.label = "delay from sensor to motor", .unit = "s"});
  by_delay.title = "Stiffest stable wall";
  by_delay.subtitle = fmt::format(
      "Against delay: curves at {}; against rate: curves with one frame of delay. Diamonds: controllers, "
      "each with its own rate and delay, for the device '{}'. {} of {} stability limits confirmed by "
      "simulation on both sides.",
      hz(map.rate), map.devices.front().name, map.confirmed, map.borders);
  return {by_delay, plot_of(map, map.by_rate, [](const WallLimit& limit) { return limit.loop.rate.value; },
                            {.label = "sample rate", .unit = "Hz"})};
}

namespace {

struct WallOptions : StudyOptions {
  std::array<std::string, std::size(kDeviceQuantities)> device;
  std::string rate, wall_damping;
  int points = 8;
};

/// A finger on the tip: Hajian & Howe, J. Biomechanical Engineering 119, 1997, as a range of magnitudes.
constexpr double kLightMass = 5e-3, kFirmMass = 10e-3;     // [kg]
constexpr double kLightDamping = 1.0, kFirmDamping = 5.0;  // [N s/m]

/// The device and the loop of the options and the scene.
WallStudy study_of(const WallOptions& options) {
  WallStudy study;
  study.controllers = controllers_of_the_paper();
  study.points_per_decade = options.points;
  SceneDevice device{.bare = {.quantum = 0.15708e-3, .force_limit = 6.37}};
  if (!options.target.empty()) {
    const auto scene = load_target(options);
    device = or_exit(device_of(scene));
    study.rate = scene.rate;
    study.controllers.push_back({"this scene", scene.rate, scene.delay, 0});
  }
  for (std::size_t i = 0; i < options.device.size(); ++i) {
    const auto& quantity = kDeviceQuantities[i];
    read_option(options.device[i], quantity.unit, quantity.option, quantity.least, 1e9,
                device.bare.*quantity.value);
  }
  read_option(options.wall_damping, "N s/m", "wall-damping", 0, 1e9, study.damping);
  read_option(options.rate, "Hz", "rate", 100, 1e9, study.rate.value);
  study.devices = {{"bare", device.bare}, {"held lightly", device.bare.held(kLightMass, kLightDamping)}};
  if (device.hand.damping > 0) study.devices.push_back({"in this scene", device.held()});
  study.devices.push_back({"held firmly", device.bare.held(kFirmMass, kFirmDamping)});
  return study;
}

int run_stability(const WallOptions& options) {
  const auto study = study_of(options);
  RunPlan plan;
  read_run_plan(options, plan);
  SweepMonitor monitor{"walls", plan};
  const auto map = or_exit(map_walls(study, plan));
  if (const auto exit = monitor.end(map.finished, map.runs)) return *exit;
  publish(options, text_of(map), json_of(map), plots_of(map));
  return map.confirmed == map.borders ? kDone : kNo;
}

}  // namespace

void add_study_stability(CLI::App& study, int& exit_code) {
  auto [command, options] = add_command(
      study, "stability",
      "Stiffest stable virtual wall against delay and sample rate, with and without a finger on the device",
      exit_code, run_stability);
  add_study_options(
      command, options,
      "scene that gives controls the roles device_mass, device_damping, device_friction, encoder_step and "
      "force_limit; default: 50 g, 0.1 N s/m, no friction, encoder step 0.157 mm, force limit 6.37 N");
  for (std::size_t i = 0; i < options.device.size(); ++i)
    command.add_option(std::string{"--"} + kDeviceQuantities[i].option, options.device[i],
                       kDeviceQuantities[i].doc);
  command.add_option("--wall-damping", options.wall_damping,
                     "damping of the walls, applied to the differentiated position, such as \"0.1 N s/m\"");
  command.add_option("--rate", options.rate,
                     "sample rate; of the curves against delay; default: the scene's, or 20 kHz");
  add_number(command, "--points", options.points, "points per decade on each curve", 1, 100);
  command.footer(
      "Examples:\n  tactus study stability instruments/wall --svg walls.svg\n  tactus study stability "
      "--device-mass \"20 g\" --device-damping \"0.3 N s/m\" --rate \"8 kHz\"\ndocs/walls.md explains the "
      "stability map. "
      "Exit code 1: a stability limit was not confirmed by simulation. 5: interrupted.");
}

}  // namespace tactus::app
