#include "apps/study/wall_report.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;
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
  if (device.quantum > 0) text += fmt::format(", read in steps of {:.4g} mm", 1e3 * device.quantum);
  if (std::isfinite(device.force_limit)) text += fmt::format(", up to {:g} N", device.force_limit);
  return text + "\n";
}

std::string head(const WallMap& map, const std::string& what) {
  auto text = fmt::format("{:<26}", what);
  for (const auto& mapped : map.devices) text += fmt::format("{:>16}", mapped.name);
  return text + fmt::format("{:>16}\n", map.devices.front().name + ", passive");
}

std::string curve_text(const WallMap& map, const Curves& curves, const std::string& what,
                       const std::function<std::string(const WallLimit&)>& name) {
  auto text = head(map, what);
  const auto last = curves.front().size() - 1;
  for (std::size_t i = 0; i <= last; i = i == last ? last + 1 : std::min(last, i + kRows)) {
    text += fmt::format("  {:<24}", name(curves.front()[i]));
    for (const auto& curve : curves) text += fmt::format("{:>16}", n_per_m(curve[i].stiffest));
    text += fmt::format("{:>16}\n", n_per_m(curves.front()[i].passive));
  }
  return text;
}

std::string controllers_text(const WallMap& map) {
  auto text = head(map, "controllers");
  for (const auto& [controller, limits, fixed] : map.controllers) {
    text += fmt::format("  {:<24}",
                        fmt::format("{} {} {}", controller.name, hz(controller.rate), ms(controller.delay)));
    for (const auto& limit : limits) text += fmt::format("{:>16}", n_per_m(limit.stiffest));
    text += fmt::format("{:>16}\n", n_per_m(limits.front().passive));
  }
  return text;
}

std::string fixed_point_text(const MappedController& mapped) {
  if (!mapped.fixed_point) return {};
  const auto& fixed = *mapped.fixed_point;
  return fmt::format(
      "  {} reckons in {} bits: force in steps of {:.3g} mN, stiffness in steps of {}; the motor's limit is "
      "reached\n  {:.2g} mm deep. In the simulation its border lies at {} with the encoder alone, at {} with "
      "the bits too.\n",
      mapped.controller.name, mapped.controller.bits, 1e3 * fixed.force_step, n_per_m(fixed.stiffness_step),
      1e3 * fixed.full_depth, n_per_m(fixed.with_encoder), n_per_m(fixed.with_bits));
}

/// Nothing where the position has no steps.
std::string friction_text(double limit) {
  if (!std::isfinite(limit)) return {};
  if (limit > 0)
    return fmt::format("\nDry friction stills what the steps of the encoder stir, up to {}.\n",
                       n_per_m(limit));
  return "\nWithout dry friction a hand that leans between two steps of the encoder feels every wall "
         "tremble.\n";
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

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
  auto json = Json::array();
  for (const auto& limit : limits) json.push_back(part_json(limit));
  return json;
}

Json part_json(const MappedController& mapped, const std::vector<MappedDevice>& devices) {
  Json json{{"name", mapped.controller.name}, {"limits", Json::object()}};
  for (std::size_t d = 0; d < devices.size(); ++d)
    json["limits"][devices[d].name] = part_json(mapped.limits[d]);
  if (const auto& fixed = mapped.fixed_point)
    json["fixed_point"] = {{"bits", mapped.controller.bits},
                           {"force_step_n", fixed->force_step},
                           {"stiffness_step_n_per_m", fixed->stiffness_step},
                           {"full_depth_m", fixed->full_depth},
                           {"border_with_encoder_n_per_m", fixed->with_encoder},
                           {"border_with_bits_n_per_m", fixed->with_bits}};
  return json;
}

double delay_of(const WallLimit& limit) { return limit.loop.delay.value; }
double rate_of(const WallLimit& limit) { return limit.loop.rate.value; }

PlotSeries series_of(const std::string& label, const std::vector<WallLimit>& limits, const Abscissa& x,
                     double WallLimit::*y) {
  PlotSeries series;
  series.label = label;
  for (const auto& limit : limits) {
    series.x.push_back(x(limit));
    series.y.push_back(limit.*y);
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
    plot.regions.push_back({"in a hand, light to firm", low.x, low.y, high.y, PlotColor::Green});
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
  for (const auto& [controller, limits, fixed] : map.controllers)
    plot.pins.push_back(
        {x(limits.front()), limits.front().stiffest,
         controller.name + (controller.bits > 0 ? fmt::format(", {} bit", controller.bits) : ""),
         PlotColor::Black});
  axis.log = true;
  return {.x = std::move(axis), .subplots = {std::move(plot)}, .subplot_height = 420};
}

}  // namespace

std::string text_of(const WallMap& map) {
  std::string text = "The stiffest wall that does not explode\n";
  for (const auto& mapped : map.devices) text += describe(mapped);
  text += "\n" + curve_text(map, map.by_delay, "delay, at " + hz(map.rate),
                            [](const WallLimit& limit) { return ms(limit.loop.delay); });
  text += "\n" + curve_text(map, map.by_rate, "rate, one frame of delay",
                            [](const WallLimit& limit) { return hz(limit.loop.rate); });
  text += "\n" + controllers_text(map);
  for (const auto& controller : map.controllers) text += fixed_point_text(controller);
  return text + friction_text(map.friction_limit) +
         fmt::format(
             "\n{} of {} borders confirmed: at 0.98 of each the simulation decays, at 1.02 it "
             "grows.\n",
             map.confirmed(), map.borders());
}

Json json_of(const WallMap& map) {
  Json json{{"devices", Json::array()},
            {"by_delay", Json::object()},
            {"by_rate", Json::object()},
            {"controllers", Json::array()}};
  for (std::size_t d = 0; d < map.devices.size(); ++d) {
    const auto& [name, device] = map.devices[d];
    json["devices"].push_back({{"name", name},
                               {"mass_kg", device.mass},
                               {"damping_n_s_per_m", device.damping},
                               {"friction_n", device.friction},
                               {"step_m", device.quantum},
                               {"force_limit_n", number(device.force_limit)}});
    json["by_delay"][name] = part_json(map.by_delay[d]);
    json["by_rate"][name] = part_json(map.by_rate[d]);
  }
  for (const auto& controller : map.controllers)
    json["controllers"].push_back(part_json(controller, map.devices));
  json["friction_limit_n_per_m"] = number(map.friction_limit);
  json["borders"] = map.borders();
  json["confirmed"] = map.confirmed();
  return json;
}

std::vector<Plot> picture_of(const WallMap& map) {
  auto by_delay = plot_of(map, map.by_delay, delay_of, {.label = "delay from sensor to motor", .unit = "s"});
  by_delay.title = "The stiffest stable wall";
  by_delay.subtitle = fmt::format(
      "Over the delay: curves at {}; over the rate: curves with one frame of delay. Diamonds: controllers, "
      "each with its own rate and delay, for the device '{}'. {} of {} borders confirmed by simulation on "
      "both sides.",
      hz(map.rate), map.devices.front().name, map.confirmed(), map.borders());
  return {by_delay, plot_of(map, map.by_rate, rate_of, {.label = "sample rate", .unit = "Hz"})};
}

}  // namespace tactus::app
