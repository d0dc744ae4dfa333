#include "apps/check/check_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/decibels.h"
#include "engine/graph/file/read_graph.h"
#include "engine/nodes/networks/solver_names.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

/// What has no end is no number in JSON.
Json finite(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

Json margin_json(const CutMargin& margin) {
  return {{"border_factor", finite(margin.border)},
          {"border_hz", margin.border_hz},
          {"least_factor_above", finite(margin.up)},
          {"largest_factor_below", margin.down},
          {"gain_margin_db", finite(20 * std::log10(margin.border))},
          {"peak_gain", margin.peak},
          {"peak_hz", margin.peak_hz},
          {"holds_at_every_delay", margin.peak < 1},
          {"more_delay_ms", finite(1e3 * margin.more_delay_s)}};
}

Json regime_json(const RegimeVerdict& regime) {
  Json json{{"regime", regime.name}, {"held", regime.held}, {"roots_that_grow", regime.growing}};
  json["roots"] = Json::array();
  for (const auto& root : regime.roots)
    json["roots"].push_back({{"hz", root.frequency_hz}, {"growth_per_s", root.growth_per_s}});
  json["loops"] = Json::array();
  for (const auto& loop : regime.loops) {
    auto entry = margin_json(loop.margin);
    entry.update({{"at", loop.at},
                  {"through", loop.way},
                  {"drive", loop.drive},
                  {"joint", loop.wave_port},
                  {"integrates", loop.integrates()},
                  {"growth_per_s_below_border", loop.growth_below},
                  {"growth_per_s_above_border", loop.growth_above}});
    json["loops"].push_back(std::move(entry));
  }
  json["stiff"] = Json::array();
  for (const auto& stiff : regime.stiff)
    json["stiff"].push_back(
        {{"name", stiff.path},
         {"type", stiff.type},
         {"n_per_m", stiff.stiffness},
         {"stable_up_to_n_per_m", finite(stiff.stable_up_to)},
         {"border_hz", stiff.border_hz},
         {"passive_up_to_n_per_m", stiff.passive_up_to ? finite(*stiff.passive_up_to) : Json()}});
  json["crests"] = regime.unstable_equilibria;
  json["device_damping_n_s_per_m"] = regime.device_damping ? finite(*regime.device_damping) : Json();
  return json;
}

Json network_json(const NetworkVerdict& network) {
  return {{"name", network.path},
          {"regime", network.regime},
          {"solver", name_of(network.solver)},
          {"spectral_radius", network.radius},
          {"rate_hz", network.rate_hz},
          {"holds_at_every_rate", !network.needed_hz.has_value()},
          {"needs_hz", network.needed_hz ? finite(*network.needed_hz) : Json()},
          {"weakest", network.weakest},
          {"contact_steps", finite(network.contact_steps)},
          {"contact_too_deep", network.too_deep},
          {"holds", network.stable}};
}

Json run_json(const ExtremeRun& run) {
  return {{"what", run.what},
          {"rate_hz", run.rate.value},
          {"delay_ms", 1e3 * run.delay_s},
          {"seconds", run.seconds},
          {"peak", run.peak},
          {"before", finite(run.energy_before)},
          {"after", finite(run.energy_after)},
          {"faults", run.faults},
          {"finite", run.finite},
          {"grew", run.grew},
          {"expected_to_hold", run.expected},
          {"as_expected", run.as_expected()}};
}

Json control_json(const ControlVerdict& control) {
  return {{"name", control.control.name},
          {"value", control.control.value},
          {"low", control.control.range.low},
          {"high", control.control.range.high},
          {"holds_at_low", control.stable_low},
          {"holds_at_high", control.stable_high},
          {"border", control.border ? Json(*control.border) : Json()}};
}

template <class List, class Convert>
Json list_of(const List& list, Convert convert) {
  Json json = Json::array();
  for (const auto& item : list) json.push_back(convert(item));
  return json;
}

std::string decibels(double factor) {
  return std::isfinite(factor) && factor > 0 ? fmt::format("{:.1f} dB", amplitude_to_db(factor)) : "any";
}

void print_loops(const StabilityVerdict& verdict) {
  fmt::print("\n  {:28} {:8} {:24} {:>10} {:>9} {:>10} {:>10}\n", "regime", "device", "loop at", "margin",
             "Hz", "peak gain", "more delay");
  for (const auto& regime : verdict.regimes)
    for (const auto& loop : regime.loops)
      fmt::print("  {:28} {:8} {:24} {:>10} {:9.4g} {:10.3g} {:>10}\n", regime.name,
                 regime.held ? "held" : "bare", loop.at,
                 loop.wave_port      ? "passive"
                 : loop.integrates() ? "integrates"
                                     : decibels(loop.margin.border),
                 loop.margin.border_hz, loop.margin.peak,
                 std::isfinite(loop.margin.more_delay_s)
                     ? fmt::format("{:.3g} ms", 1e3 * loop.margin.more_delay_s)
                     : "any");
}

void print_stiff(const StabilityVerdict& verdict) {
  fmt::print("\n  {:28} {:8} {:24} {:>12} {:>12} {:>12}\n", "regime", "device", "spring or wall", "N/m",
             "stable to", "passive to");
  const auto number = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.4g}", value) : "any";
  };
  for (const auto& regime : verdict.regimes)
    for (const auto& stiff : regime.stiff)
      fmt::print("  {:28} {:8} {:24} {:12.4g} {:>12} {:>12}\n", regime.name, regime.held ? "held" : "bare",
                 stiff.path, stiff.stiffness, number(stiff.stable_up_to),
                 stiff.passive_up_to ? number(*stiff.passive_up_to) : "not known");
}

void print_networks(const StabilityVerdict& verdict) {
  fmt::print("\n  {:24} {:28} {:8} {:>14} {:>10} {:>12}  {}\n", "network", "regime", "solver", "radius",
             "runs at", "needs", "weakest");
  for (const auto& network : verdict.networks)
    fmt::print("  {:24} {:28} {:8} {:14.10f} {:10g} {:>12}  {}\n", network.path, network.regime,
               name_of(network.solver), network.radius, network.rate_hz,
               !network.needed_hz                  ? "any"
               : std::isfinite(*network.needed_hz) ? fmt::format("{:.5g} Hz", *network.needed_hz)
                                                   : "none holds",
               network.weakest);
}

void print_controls(const StabilityVerdict& verdict) {
  fmt::print("\n  {:24} {:>14} {:>14} {:>14}\n", "control", "at its lowest", "at its highest", "border");
  for (const auto& control : verdict.controls)
    fmt::print("  {:24} {:>14} {:>14} {:>14}\n", control.control.name,
               control.stable_low ? "stable" : "unstable", control.stable_high ? "stable" : "unstable",
               control.border ? in_unit(*control.border, control.control.unit) : "");
}

void print_runs(const std::vector<ExtremeRun>& runs) {
  fmt::print("\n  {:34} {:>9} {:>10} {:>8} {:>10} {:>10} {:>10}  {:8}  {}\n", "run", "rate Hz", "delay ms",
             "seconds", "peak", "before", "after", "predicted", "measured");
  for (const auto& run : runs) {
    const char* how = !run.finite ? "not finite" : run.faults > 0 ? "faults" : run.grew ? "grew" : "bounded";
    fmt::print("  {:34} {:9g} {:10.4g} {:8.3g} {:10.3g} {:10.3g} {:10.3g}  {:8}  {}{}\n", run.what,
               run.rate.value, 1e3 * run.delay_s, run.seconds, run.peak, run.energy_before, run.energy_after,
               run.expected ? "stable" : "unstable", how, run.as_expected() ? "" : "  (not as predicted)");
  }
}

}  // namespace

nlohmann::ordered_json to_json(const CheckedSubject& subject, const StabilityVerdict& verdict,
                               const std::vector<ExtremeRun>& runs) {
  Json json{{"name", subject.name},
            {"holds", holds(verdict, runs)},
            {"outside_known", verdict.outside_known},
            {"sample_rate_hz", verdict.rate.value},
            {"delay_ms", 1e3 * verdict.delay_s},
            {"delay_from", subject.delay_from},
            {"words", describe(verdict)}};
  json["regimes"] = list_of(verdict.regimes, regime_json);
  json["networks"] = list_of(verdict.networks, network_json);
  json["controls"] = list_of(verdict.controls, control_json);
  json["events"] = list_of(verdict.events, [](const EventVerdict& event) -> Json {
    return {{"name", event.place.path},
            {"type", event.place.type},
            {"hold_s", event.place.hold_s ? Json(*event.place.hold_s) : Json()},
            {"on_loop", event.on_loop}};
  });
  json["open"] = list_of(verdict.open, [](const OpenVerdict& open) -> Json {
    return {
        {"input", open.input}, {"output", open.output}, {"peak_gain", open.peak}, {"peak_hz", open.peak_hz}};
  });
  json["not_looked_at"] = verdict.skipped;
  json["runs"] = list_of(runs, run_json);
  return json;
}

bool holds(const StabilityVerdict& verdict, const std::vector<ExtremeRun>& runs) {
  bool all = verdict.stable;
  for (const auto& run : runs) all = all && run.as_expected();
  return all;
}

void print(const CheckedSubject& subject, const StabilityVerdict& verdict,
           const std::vector<ExtremeRun>& runs, bool verbose) {
  fmt::print("{}\n\n", !holds(verdict, runs)   ? "unstable"
                       : verdict.outside_known ? "stable"
                                               : "stable by itself; the loop over the outside is not known");
  const auto words = describe(verdict);
  fmt::print("{}: {} ({})\n", subject.name, words.front(), subject.delay_from);
  for (std::size_t i = 1; i < words.size(); ++i) fmt::print("  {}\n", words[i]);
  for (const auto& run : runs)
    if (!run.as_expected()) fmt::print("  not as predicted: {}\n", run.what);
  if (!verbose) return;
  const auto any = [&](auto list) {
    return std::any_of(verdict.regimes.begin(), verdict.regimes.end(),
                       [&](const RegimeVerdict& regime) { return !(regime.*list).empty(); });
  };
  if (any(&RegimeVerdict::loops)) print_loops(verdict);
  if (any(&RegimeVerdict::stiff)) print_stiff(verdict);
  if (!verdict.networks.empty()) print_networks(verdict);
  if (!verdict.controls.empty()) print_controls(verdict);
  if (!runs.empty()) print_runs(runs);
}

}  // namespace tactus::app
