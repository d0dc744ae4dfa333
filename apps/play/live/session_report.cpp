#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/play/live/controls/status_line.h"
#include "apps/play/live/session.h"
#include "apps/play/play_report.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Health& health) {
  Json gaps = Json::object();
  for (std::size_t g = 0; g < kGaps; ++g) gaps[name_of(static_cast<Gap>(g))] = health.gaps[g];
  return {{"blocks", health.blocks},
          {"frames", health.frames},
          {"xruns", health.xruns},
          {"xruns_by_cause", gaps},
          {"lost_frames", health.lost_frames},
          {"late_blocks", health.late_blocks},
          {"bad_input_samples", health.bad_input},
          {"load_median", health.median_load},
          {"load_p999", health.high_load},
          {"load_worst", health.peak_load},
          {"realtime_priority", health.realtime_priority}};
}

Json json_of(const std::vector<SessionView::Level>& levels) {
  Json json = Json::object();
  for (const auto& level : levels) json[level.name] = level.peak;
  return json;
}

Json json_of(Session& session, const SessionView& view, const Performer& performer) {
  const auto& granted = session.granted();
  Json json{{"instrument", performer.name()},
            {"device", granted.device},
            {"sample_rate_hz", granted.format.sample_rate.value},
            {"block_frames", granted.block_frames},
            {"highest_input", json_of(view.highest_inputs)},
            {"highest_output", json_of(view.highest_outputs)},
            {"health", json_of(view.health)},
            {"takes", Json::array()},
            {"guard", guard_json(session.guard_report(), granted.format.sample_rate)}};
  for (const auto& take : session.takes()) json["takes"].push_back(take.string());
  if (const auto ports = performer.ports(); !ports.empty()) json["ports"] = ports_json(ports);
  return json;
}

}  // namespace

void print_report(Session& session, const SessionView& view, const Performer& performer, bool as_json) {
  if (as_json) return fmt::print("{}\n", json_of(session, view, performer).dump(2));
  for (const auto* levels : {&view.highest_inputs, &view.highest_outputs})
    for (const auto& level : *levels)
      fmt::print("  {:<18}  {} at most\n", level.name, level_text(level.peak));
  fmt::print("  load                {}\n", load_text(view.health));
  fmt::print("  gaps                {}\n", xrun_text(view.health));
  if (view.health.bad_input > 0)
    fmt::print("  bad input           {} non-finite samples replaced by zero\n", view.health.bad_input);
  print_guard(session.guard_report(), session.granted().format.sample_rate);
  print_ports(performer.ports());
  for (const auto& take : session.takes()) fmt::print("  take                {}\n", take.string());
}

}  // namespace tactus::app
