#include <array>
#include <numeric>

#include "apps/latency/latency_report.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json known(bool is_known, const T& value) {
  return is_known ? Json(value) : Json(nullptr);
}

Json json_of(const std::vector<SweepDelay>& sweeps, Hertz rate) {
  Json all = Json::array();
  for (const auto& sweep : sweeps)
    all.push_back({{"played_at_s", static_cast<double>(sweep.played_at) / rate.value},
                   {"delay_frames", sweep.delay_frames},
                   {"gain_db", sweep.gain_db},
                   {"level", sweep.level}});
  return all;
}

Json json_of(const std::vector<DelayStep>& steps, Hertz rate) {
  Json all = Json::array();
  for (const auto& step : steps)
    all.push_back({{"at_s", static_cast<double>(step.frame) / rate.value}, {"frames", step.frames}});
  return all;
}

Json json_of(const std::vector<BandDelay>& bands) {
  Json all = Json::array();
  for (const auto& band : bands)
    all.push_back({{"centre_hz", band.centre_hz},
                   {"delay_frames", band.delay_frames},
                   {"standard_error_frames", band.standard_error_frames}});
  return all;
}

Json harmonics_json(const Analysis& analysis) {
  Json all = Json::object();
  for (std::size_t k = 0; k < analysis.harmonics_db.size(); ++k) {
    const auto& harmonic = analysis.harmonics_db[k];
    all["h" + std::to_string(k + 2)] = harmonic ? Json(*harmonic) : Json(nullptr);
  }
  return all;
}

/// What one recording shows, but for the delay itself.
void add_evidence(const Analysis& analysis, Json& json) {
  const bool detected = analysis.detected;
  json["drift_standard_error_ppm"] = known(detected && analysis.compared, analysis.drift_standard_error_ppm);
  json["bound_frames"] = known(detected, analysis.bound_frames);
  json["spread_over_sweeps_frames"] = known(detected, analysis.spread_frames);
  json["noise_floor_dbfs"] = known(is_known(analysis), analysis.noise_floor_dbfs);
  json["dc"] = known(is_known(analysis), analysis.dc);
  json["low_hz"] = known(detected, analysis.low_hz);
  json["high_hz"] = known(detected, analysis.high_hz);
  json["high_pass_hz"] = known(detected, analysis.high_pass_hz);
  json["misfit"] = known(detected, analysis.misfit);
  json["harmonics_db"] = harmonics_json(analysis);
  json["group_delay"] = json_of(analysis.group_delay);
  json["sweeps"] = json_of(analysis.sweeps, analysis.sample_rate);
  json["steps"] = json_of(analysis.steps, analysis.sample_rate);
}

Json granted_json(const StreamGranted& granted) {
  const auto figure = [](const std::optional<double>& frames) {
    return frames ? Json(*frames) : Json(nullptr);
  };
  return {{"device", granted.device},
          {"input_device", granted.input_device.empty() ? granted.device : granted.input_device},
          {"sample_rate_hz", granted.format.sample_rate.value},
          {"block_frames", granted.block_frames},
          {"periods", known(granted.periods > 0, granted.periods)},
          {"driver_input_latency_frames", figure(granted.input_latency_frames)},
          {"driver_output_latency_frames", figure(granted.output_latency_frames)}};
}

Json health_json(const Health& health) {
  Json by_cause = Json::object();
  for (std::size_t g = 0; g < kGaps; ++g) by_cause[name_of(static_cast<Gap>(g))] = health.gaps[g];
  return {{"xruns", health.xruns},
          {"xruns_by_cause", by_cause},
          {"lost_frames_counted", health.lost_frames},
          {"late_blocks", health.late_blocks}};
}

Json opening_json(const Opening& opening, bool live) {
  const auto& analysis = opening.analysis;
  const auto rate = live ? opening.granted.format.sample_rate : analysis.sample_rate;
  auto json = essentials_json({opening.finding, rate, analysis.delay_frames, analysis.standard_error_frames},
                              analysis);
  if (live) {
    json["level_dbfs"] = opening.level_dbfs;
    json["setting"] = granted_json(opening.granted);
    json["health"] = health_json(opening.health);
  }
  add_evidence(analysis, json);
  return json;
}

}  // namespace

Json essentials_json(const Essentials& of, const Analysis& analysis) {
  const bool ok = of.finding.verdict == Verdict::Ok, detected = analysis.detected;
  return {{"verdict", code(of.finding.verdict)},
          {"what", of.finding.what},
          {"remedy", of.finding.remedy},
          {"delay_frames", known(ok, of.delay_frames)},
          {"delay_ms", known(ok, 1e3 * of.delay_frames / of.sample_rate.value)},
          {"standard_error_frames", known(ok, of.standard_error_frames)},
          {"polarity", known(detected, analysis.polarity)},
          {"gain_db", known(detected, analysis.gain_db)},
          {"snr_db", known(detected, analysis.snr_db)},
          {"drift_ppm", known(detected && analysis.compared, analysis.drift_ppm)}};
}

Json json_of(const LatencyReport& report) {
  const auto& measurement = report.measurement;
  const auto rate = report.sample_rate();
  const auto* shown = report.shown();
  const auto analysis = shown == nullptr ? Analysis{} : shown->analysis;
  Json json{{"source", report.source}};
  json.update(essentials_json(
      {measurement.finding, rate, measurement.delay_frames, measurement.standard_error_frames}, analysis));
  json["delay_is"] = kDelayIs;
  json["sample_rate_hz"] = rate.value;
  if (shown != nullptr) add_evidence(analysis, json);
  if (report.live) {
    json["spread_over_openings_frames"] = measurement.spread_frames;
    json["reported_frames"] =
        measurement.reported_frames ? Json(*measurement.reported_frames) : Json(nullptr);
    Health all;
    for (const auto& opening : measurement.openings) all = together(all, opening.health);
    json.update(health_json(all));
    if (shown != nullptr) json["setting"] = granted_json(shown->granted);
  }
  json["openings"] = Json::array();
  for (const auto& opening : measurement.openings)
    json["openings"].push_back(opening_json(opening, report.live));
  json["kept"] = report.kept;
  json["written"] = report.written;
  return json;
}

}  // namespace tactus::app
