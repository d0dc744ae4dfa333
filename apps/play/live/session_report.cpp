#include "apps/play/live/session_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/cli/guard_options.h"
#include "apps/play/live/controls/status_line.h"
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

Json takes_json(const Session& session) {
  Json json = Json::array();
  for (const auto& take : session.takes()) json.push_back(take.string());
  return json;
}

void print_json(const Session& session, const SessionView& view, const Performer& performer,
                const GuardReport& guard) {
  const auto& granted = session.granted();
  Json json{{"instrument", performer.name()},
            {"device", granted.device},
            {"sample_rate_hz", granted.format.sample_rate.value},
            {"block_frames", granted.block_frames},
            {"highest_input", json_of(view.highest_inputs)},
            {"highest_output", json_of(view.highest_outputs)},
            {"health", json_of(view.health)},
            {"takes", takes_json(session)},
            {"guard", guard_json(guard, granted.format.sample_rate)}};
  if (const auto ports = performer.ports(); !ports.empty()) json["ports"] = ports_json(ports);
  fmt::print("{}\n", json.dump(2));
}

void print_text(const Session& session, const SessionView& view, const Performer& performer,
                const GuardReport& guard) {
  for (const auto& level : view.highest_inputs)
    fmt::print("  {:<18}  {} at most\n", level.name, level_text(level.peak));
  for (const auto& level : view.highest_outputs)
    fmt::print("  {:<18}  {} at most\n", level.name, level_text(level.peak));
  fmt::print("  load                {}\n", load_text(view.health));
  fmt::print("  gaps                {}\n", xrun_text(view.health));
  if (view.health.bad_input > 0)
    fmt::print("  bad input           {} samples were no numbers and counted as silence\n",
               view.health.bad_input);
  print_guard(guard, session.granted().format.sample_rate);
  print_ports(performer.ports());
  for (const auto& take : session.takes()) fmt::print("  take                {}\n", take.string());
}

}  // namespace

void print_report(Session& session, const SessionView& view, const Performer& performer, bool as_json) {
  const auto guard = session.guard_report();
  if (as_json)
    print_json(session, view, performer, guard);
  else
    print_text(session, view, performer, guard);
}

}  // namespace tactus::app
