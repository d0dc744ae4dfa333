#include "apps/latency/latency_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::vector<ProbeDelay>& probes, Hertz rate) {
  Json all = Json::array();
  for (const auto& probe : probes)
    all.push_back({{"played_at_s", static_cast<double>(probe.played_at) / rate.value},
                   {"delay_frames", probe.delay_frames},
                   {"gain_db", probe.gain_db},
                   {"level", probe.level}});
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
  for (std::size_t k = 0; k < analysis.harmonics_db.size(); ++k)
    all["h" + std::to_string(k + 2)] = known(analysis.harmonics_db[k]);
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
  json["sweeps"] = json_of(analysis.probes, analysis.sample_rate);
  json["steps"] = json_of(analysis.steps, analysis.sample_rate);
}

Json granted_json(const StreamGranted& granted) {
  return {{"device", granted.device},
          {"input_device", granted.input_device.empty() ? granted.device : granted.input_device},
          {"sample_rate_hz", granted.format.sample_rate.value},
          {"block_frames", granted.block_frames},
          {"periods", known(granted.periods > 0, granted.periods)},
          {"driver_input_latency_frames", known(granted.input_latency_frames)},
          {"driver_output_latency_frames", known(granted.output_latency_frames)}};
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

Health health_of(const Measurement& measurement) {
  Health all;
  for (const auto& opening : measurement.openings) all = together(all, opening.health);
  return all;
}

/// Lines with a heading in the left column.
class Lines {
 public:
  template <class... Args>
  void add(const char* heading, fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), "{:<13}  {}\n", heading,
                   fmt::format(format, std::forward<Args>(args)...));
  }
  void blank() { text_ += '\n'; }
  /// Text that may need several lines.
  void wrap(const char* heading, const std::string& text) {
    constexpr std::size_t kWidth = 85;
    std::size_t at = 0;
    while (at < text.size()) {
      auto end = text.size();
      if (end - at > kWidth) end = text.rfind(' ', at + kWidth);
      if (end == std::string::npos || end <= at) end = text.size();
      add(std::exchange(heading, ""), "{}", text.substr(at, end - at));
      at = end + 1;
    }
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string frequency(double hertz) {
  return hertz < 1000 ? fmt::format("{:.0f} Hz", hertz) : fmt::format("{:.3g} kHz", hertz / 1e3);
}

void add_delay(const LatencyReport& report, Lines& lines) {
  const auto& measurement = report.measurement;
  if (report.ok()) {
    const double ms = 1e3 / report.sample_rate().value;
    lines.add("delay", "{} frames, {} ms",
              with_error(measurement.delay_frames, measurement.standard_error_frames),
              with_error(measurement.delay_frames * ms, measurement.standard_error_frames * ms));
    lines.wrap("", kDelayIs);
    lines.wrap("note", measurement.finding.what);
  } else {
    lines.add("delay", "not known: {}", code(measurement.finding.verdict));
    lines.wrap("cause", measurement.finding.what);
    lines.wrap("remedy", measurement.finding.remedy);
  }
}

void add_openings(const LatencyReport& report, Lines& lines) {
  const auto& measurement = report.measurement;
  const auto& shown = *report.shown();
  if (report.live) {
    std::string delays;
    bool numbers = false;
    for (const auto& opening : measurement.openings) {
      const bool ok = opening.finding.verdict == Verdict::Ok;
      delays += (delays.empty() ? "" : "  ") + (ok ? fmt::format("{:.3f}", opening.analysis.delay_frames)
                                                   : std::string{code(opening.finding.verdict)});
      numbers = numbers || ok;
    }
    lines.wrap("openings", delays + (numbers ? " [frames]" : ""));
  }
  if (measurement.openings.size() > 1 && report.ok())
    lines.add("spread", "{:.2g} frames between openings, {:.2g} between {} probes", measurement.spread_frames,
              shown.analysis.spread_frames, shown.analysis.probes.size());
  else if (shown.analysis.detected && shown.analysis.probes.size() > 1)
    lines.add("spread", "{:.2g} frames between {} probes", shown.analysis.spread_frames,
              shown.analysis.probes.size());
}

void add_driver(const LatencyReport& report, Lines& lines) {
  const auto& measurement = report.measurement;
  if (!measurement.reported_frames) return lines.add("driver", "reports no latency");
  const double reported = *measurement.reported_frames;
  const double beside = reported - measurement.delay_frames;
  lines.add("driver", "{:.0f} frames{}", reported,
            !report.ok()             ? ""
            : std::abs(beside) < 0.5 ? ", as measured"
                                     : fmt::format(": {:.1f} frames {} than measured", std::abs(beside),
                                                   beside > 0 ? "more" : "less"));
}

std::string detected_gaps(const Analysis& analysis) {
  constexpr std::size_t kMaxSteps = 4;
  const auto& steps = analysis.steps;
  if (steps.empty()) return analysis.compared ? "none detected" : "not known";
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxSteps, steps.size()); ++i)
    text += fmt::format("{}{} {:.0f} frames at {:.2f} s", i == 0 ? "" : ", ",
                        steps[i].frames < 0 ? "lost" : "repeated", std::abs(steps[i].frames),
                        static_cast<double>(steps[i].frame) / analysis.sample_rate.value);
  return steps.size() > kMaxSteps ? text + fmt::format(", and {} more times", steps.size() - kMaxSteps)
                                  : text;
}

void add_gaps(const LatencyReport& report, Lines& lines) {
  const auto& analysis = report.shown()->analysis;
  auto text = analysis.detected ? detected_gaps(analysis) : std::string{};
  if (report.live) {
    const auto health = health_of(report.measurement);
    text += text.empty() ? "" : "; ";
    text += health.xruns == 0
                ? "none counted by the driver"
                : fmt::format("{} counted by the driver, {} frames", health.xruns, health.lost_frames);
  }
  lines.wrap("gaps", text);
}

std::string noise_text(const Analysis& analysis) {
  constexpr double kNone = -200.0;  // dBFS; no converter is so quiet
  if (analysis.noise_floor_dbfs < kNone) return "none: the path contains no converter";
  const auto level = fmt::format("{:.1f} dBFS, ", analysis.noise_floor_dbfs);
  const auto dc = fmt::format("DC {:.2g}", analysis.dc);
  if (!analysis.detected) return level + dc;
  return level +
         fmt::format("{:.1f} dB {} the probes, ", std::abs(analysis.snr_db),
                     analysis.snr_db < 0 ? "above" : "below") +
         dc;
}

void add_path(const Analysis& analysis, Lines& lines) {
  if (analysis.detected)
    lines.add("path", "{} dB, {}, {} to {} within 3 dB", fixed(analysis.gain_db, 2),
              analysis.polarity > 0 ? "not inverted" : "inverted", frequency(analysis.low_hz),
              frequency(analysis.high_hz));
  if (is_known(analysis)) lines.add("noise", "{}", noise_text(analysis));
  std::string harmonics;
  for (std::size_t k = 0; k < analysis.harmonics_db.size(); ++k)
    if (const auto& level = analysis.harmonics_db[k])
      harmonics += fmt::format("{}H{} {:.0f} dB", harmonics.empty() ? "" : ", ", k + 2, *level);
  if (!harmonics.empty()) lines.add("distortion", "{}", harmonics);
  if (analysis.detected && !analysis.compared)
    lines.add("clock", "not known (nor lost frames): fewer than three probes can be compared");
  if (analysis.detected && analysis.compared)
    lines.add("clock", "drift {} ppm",
              with_error(analysis.drift_ppm, std::max(0.001, analysis.drift_standard_error_ppm)));
}

/// "±0.004", and no more digits than fit.
std::string error_text(double frames) {
  if (frames < 5e-4) return "<0.001";
  return fmt::format("±{:.{}f}", frames, frames < 1 ? 3 : 1);
}

/// Beside the delay: what a path without a delay of its own has 0 of.
void add_group_delay(const Analysis& analysis, Lines& lines) {
  if (analysis.group_delay.empty()) return;
  std::string heads, values, errors;
  for (const auto& band : analysis.group_delay) {
    const double less = band.delay_frames - analysis.delay_frames;
    heads += fmt::format("{:>8}", frequency(band.centre_hz));
    values += fmt::format("{:>8}", fixed(less, 3));
    errors += fmt::format("{:>8}", error_text(band.standard_error_frames));
  }
  lines.add("group delay", "{}", heads);
  lines.add("  minus delay", "{}  frames", values);
  lines.add("", "{}", errors);
}

}  // namespace

const char* const kDelayIs =
    "This is the delay from a voltage at the input to the response at the output if the program responds "
    "within the same block; it includes converters, driver, blocks and cable.";

bool is_known(const Analysis& analysis) {
  return analysis.detected || analysis.finding.verdict != Verdict::Ok;
}

Hertz LatencyReport::sample_rate() const {
  const auto* opening = shown();
  if (opening == nullptr) return 48_kHz;
  return live ? opening->granted.format.sample_rate : opening->analysis.sample_rate;
}

const Opening* shown_of(const Measurement& measurement) {
  const auto& openings = measurement.openings;
  const auto found = std::find_if(openings.begin(), openings.end(), [&](const Opening& opening) {
    return opening.finding.verdict == measurement.finding.verdict;
  });
  if (found != openings.end()) return &*found;
  return openings.empty() ? nullptr : &openings.front();
}

std::string fixed(double value, int digits) {
  const bool zero = std::abs(value) < 0.5 * std::pow(10.0, -digits);
  return fmt::format("{:.{}f}", zero ? 0.0 : value, digits);
}

std::string with_error(double value, double standard_error) {
  const int digits =
      standard_error > 0 ? std::clamp(static_cast<int>(std::ceil(-std::log10(standard_error))), 0, 9) : 6;
  return fixed(value, digits) + " ± " + fixed(standard_error, digits);
}

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
    json["reported_frames"] = known(measurement.reported_frames);
    json.update(health_json(health_of(measurement)));
    if (shown != nullptr) json["setting"] = granted_json(shown->granted);
  }
  json["openings"] = Json::array();
  for (const auto& opening : measurement.openings)
    json["openings"].push_back(opening_json(opening, report.live));
  json["kept"] = report.saved;
  json["written"] = report.written;
  return json;
}

std::string text_of(const LatencyReport& report) {
  Lines lines;
  add_delay(report, lines);
  lines.blank();
  lines.add("measured", "{}", report.source);
  if (report.shown() != nullptr) {
    const auto& analysis = report.shown()->analysis;
    add_openings(report, lines);
    if (report.live) add_driver(report, lines);
    if (report.live || analysis.detected) add_gaps(report, lines);
    add_path(analysis, lines);
    if (analysis.detected) add_group_delay(analysis, lines);
  }
  const char* heading = "saved";
  for (const auto& line : report.saved) lines.add(std::exchange(heading, ""), "{}", line);
  heading = "written";
  for (const auto& file : report.written) lines.add(std::exchange(heading, ""), "{}", file);
  return lines.take();
}

}  // namespace tactus::app
