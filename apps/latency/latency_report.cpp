#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <span>
#include <utility>

#include "apps/cli/rig_files.h"
#include "apps/latency/latency.h"
#include "apps/play/play_report.h"

namespace tactus::app {
namespace {

/// Was there anything to analyse? Not if the measurement was given up before.
bool is_known(const Analysis& analysis) {
  return analysis.detected || analysis.finding.verdict != Verdict::Ok;
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
  json["high_pass_standard_error_hz"] = known(analysis.high_pass_error_hz);
  json["fitted_from_hz"] = known(detected, analysis.fitted_from_hz);
  json["misfit"] = known(detected, analysis.misfit);
  json["harmonics_db"] = harmonics_json(analysis);
  const double rate = analysis.sample_rate.value;
  json["group_delay"] = list_of(analysis.group_delay, [](const BandDelay& band) -> Json {
    return {{"centre_hz", band.centre_hz},
            {"delay_frames", band.delay_frames},
            {"standard_error_frames", band.standard_error_frames}};
  });
  json["sweeps"] = list_of(analysis.probes, [rate](const ProbeDelay& probe) -> Json {
    return {{"played_at_s", static_cast<double>(probe.played_at) / rate},
            {"delay_frames", probe.delay_frames},
            {"gain_db", probe.gain_db},
            {"level", probe.level}};
  });
  json["steps"] = list_of(analysis.steps, [rate](const DelayStep& step) -> Json {
    return {{"at_s", static_cast<double>(step.frame) / rate}, {"frames", step.frames}};
  });
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
  return {{"xruns", health.xruns},
          {"xruns_by_cause", gaps_json(health)},
          {"lost_frames_counted", health.lost_frames},
          {"late_blocks", health.late_blocks}};
}

Json opening_json(const Opening& opening, bool live) {
  const auto& analysis = opening.analysis;
  auto json = essentials_json({opening.finding, analysis.delay_frames, analysis.standard_error_frames},
                              live ? opening.granted.format.sample_rate : analysis.sample_rate, analysis);
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
    lines.add("delay", "{}", delay_text(measurement, report.sample_rate()));
    lines.wrap("", report.live ? kDelayIs : kFileDelayIs);
    lines.wrap("note", measurement.finding.what);
  } else {
    lines.add("delay", "not known: {}", code(measurement.finding.verdict));
    lines.wrap("cause", measurement.finding.what);
    lines.wrap("remedy", measurement.finding.remedy);
  }
}

void add_openings(const LatencyReport& report, Lines& lines) {
  const auto& measurement = report.measurement;
  const auto& analysis = measurement.shown().analysis;
  if (report.live) {
    std::vector<std::string> delays;
    const char* unit = "";
    for (const auto& opening : measurement.openings) {
      const bool ok = opening.finding.verdict == Verdict::Ok;
      delays.push_back(ok ? fmt::format("{:.3f}", opening.analysis.delay_frames)
                          : code(opening.finding.verdict));
      if (ok) unit = " [frames]";
    }
    lines.wrap("openings", fmt::format("{}{}", fmt::join(delays, "  "), unit));
  }
  if (measurement.openings.size() > 1 && report.ok())
    lines.add("spread", "{:.2g} frames between openings, {:.2g} between {} probes", measurement.spread_frames,
              analysis.spread_frames, analysis.probes.size());
  else if (analysis.detected && analysis.probes.size() > 1)
    lines.add("spread", "{:.2g} frames between {} probes", analysis.spread_frames, analysis.probes.size());
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
  std::vector<std::string> gaps;
  for (const auto& step : std::span{steps}.first(std::min(kMaxSteps, steps.size())))
    gaps.push_back(fmt::format("{} {:.0f} frames at {:.2f} s", step.frames < 0 ? "lost" : "repeated",
                               std::abs(step.frames),
                               static_cast<double>(step.frame) / analysis.sample_rate.value));
  if (steps.size() > kMaxSteps) gaps.push_back(fmt::format("and {} more times", steps.size() - kMaxSteps));
  return fmt::format("{}", fmt::join(gaps, ", "));
}

void add_gaps(const LatencyReport& report, Lines& lines) {
  const auto& analysis = report.measurement.shown().analysis;
  std::vector<std::string> counts;
  if (analysis.detected) counts.push_back(detected_gaps(analysis));
  const auto health = health_of(report.measurement);
  if (report.live)
    counts.push_back(health.xruns == 0 ? "none counted by the driver"
                                       : fmt::format("{} counted by the driver, {} frames", health.xruns,
                                                     health.lost_frames));
  lines.wrap("gaps", fmt::format("{}", fmt::join(counts, "; ")));
}

std::string noise_text(const Analysis& analysis) {
  constexpr double kNone = -200.0;  // dBFS; no converter is so quiet
  if (analysis.noise_floor_dbfs < kNone) return "none: the path contains no converter";
  const auto ratio = fmt::format("{:.1f} dB {} the probes, ", std::abs(analysis.snr_db),
                                 analysis.snr_db < 0 ? "above" : "below");
  return fmt::format("{:.1f} dBFS, {}DC {:.2g}", analysis.noise_floor_dbfs, analysis.detected ? ratio : "",
                     analysis.dc);
}

void add_path(const Analysis& analysis, Lines& lines) {
  if (analysis.detected)
    lines.add("path", "{} dB, {}, {} to {} within 3 dB", fixed(analysis.gain_db, 2),
              polarity_text(analysis.polarity), frequency(analysis.low_hz), frequency(analysis.high_hz));
  if (analysis.detected) lines.wrap("high-pass", highpass_text(analysis));
  if (is_known(analysis)) lines.add("noise", "{}", noise_text(analysis));
  std::vector<std::string> harmonics;
  for (std::size_t k = 0; k < analysis.harmonics_db.size(); ++k)
    if (const auto& level = analysis.harmonics_db[k])
      harmonics.push_back(fmt::format("H{} {:.0f} dB", k + 2, *level));
  if (!harmonics.empty()) lines.add("distortion", "{}", fmt::join(harmonics, ", "));
  if (!analysis.detected) return;
  if (!analysis.compared)
    return lines.add("clock", "not known (nor lost frames): fewer than three probes can be compared");
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

namespace fs = std::filesystem;

/// "raw.wav" for the first, "raw_2.wav" for the second.
std::string numbered(const fs::path& file, std::size_t index) {
  if (index == 0) return file.string();
  auto name = file.stem();
  name += fmt::format("_{}", index + 1);
  name += file.extension();
  return (file.parent_path() / name).string();
}

void write_sounds(LatencyReport& report, const std::string& file) {
  const auto& openings = report.measurement.openings;
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const auto path = numbered(file, i);
    or_exit(write_recording(path, openings[i].recording));
    report.written.push_back(path);
  }
}

void write_picture(LatencyReport& report, const std::string& file) {
  or_exit(write_svg(file, picture_of(report)));
  report.written.push_back(file);
}

void write_folder(LatencyReport& report, const fs::path& folder) {
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  write_picture(report, (folder / "latency.svg").string());
  if (report.live) write_sounds(report, (folder / "latency.wav").string());
  report.written.push_back((folder / "latency.json").string());
  or_exit(write_json(report.written.back(), json_of(report)));
}

}  // namespace

Hertz LatencyReport::sample_rate() const {
  const auto& opening = measurement.shown();
  return live ? opening.granted.format.sample_rate : opening.analysis.sample_rate;
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

std::string delay_text(const DelayEstimate& delay, Hertz sample_rate) {
  return fmt::format("{} frames, {:.4f} ms", with_error(delay.delay_frames, delay.standard_error_frames),
                     1e3 * delay.delay_frames / sample_rate.value);
}

LoopHighpass highpass_of(const Analysis& analysis) {
  constexpr double kCertain = 4.0;   // standard errors
  constexpr double kMost_hz = 20.0;  // a bound above says nothing about a card
  LoopHighpass found;
  if (!analysis.detected || !analysis.high_pass_error_hz) return found;
  found.error_hz = *analysis.high_pass_error_hz;
  const double error = kCertain * found.error_hz;
  if (analysis.high_pass_hz > error && analysis.high_pass_hz < 0.5 * analysis.fitted_from_hz)
    found.corner = Hertz{analysis.high_pass_hz};
  else if (analysis.high_pass_hz + error < kMost_hz)
    found.bound = Hertz{analysis.high_pass_hz + error};
  return found;
}

std::string highpass_text(const Analysis& analysis) {
  const auto found = highpass_of(analysis);
  const auto from = fmt::format("fitted from {:.0f} Hz up", analysis.fitted_from_hz);
  if (found.corner)
    return fmt::format("{} Hz: sum of the corners of output and input, {}; {}",
                       with_error(found.corner->value, found.error_hz), from, decay_text(*found.corner));
  if (found.bound)
    return fmt::format("below {:.2g} Hz, output and input together, {}", found.bound->value, from);
  return "not measured: " + (analysis.high_pass_error_hz ? "the noise hides it, " + from
                                                         : std::string{"the path has a response of its own"});
}

const char* polarity_text(int polarity) { return polarity > 0 ? "not inverted" : "inverted"; }

Json essentials_json(const DelayEstimate& delay, Hertz sample_rate, const Analysis& analysis) {
  const auto& finding = delay.finding;
  const bool ok = finding.verdict == Verdict::Ok, detected = analysis.detected;
  return {{"verdict", code(finding.verdict)},
          {"what", finding.what},
          {"remedy", finding.remedy},
          {"delay_frames", known(ok, delay.delay_frames)},
          {"delay_ms", known(ok, 1e3 * delay.delay_frames / sample_rate.value)},
          {"standard_error_frames", known(ok, delay.standard_error_frames)},
          {"polarity", known(detected, analysis.polarity)},
          {"gain_db", known(detected, analysis.gain_db)},
          {"snr_db", known(detected, analysis.snr_db)},
          {"drift_ppm", known(detected && analysis.compared, analysis.drift_ppm)}};
}

Json json_of(const LatencyReport& report) {
  const auto& measurement = report.measurement;
  const auto rate = report.sample_rate();
  const auto& shown = measurement.shown();
  Json json{{"source", report.source}};
  json.update(essentials_json(measurement, rate, shown.analysis));
  json["delay_is"] = report.live ? kDelayIs : kFileDelayIs;
  json["sample_rate_hz"] = rate.value;
  add_evidence(shown.analysis, json);
  if (report.live) {
    json["spread_over_openings_frames"] = measurement.spread_frames;
    json["reported_frames"] = known(measurement.reported_frames);
    json.update(health_json(health_of(measurement)));
    json["setting"] = granted_json(shown.granted);
  }
  json["openings"] = list_of(measurement.openings,
                             [&](const Opening& opening) { return opening_json(opening, report.live); });
  json["kept"] = report.saved;
  json["written"] = report.written;
  return json;
}

std::string text_of(const LatencyReport& report) {
  Lines lines;
  add_delay(report, lines);
  lines.blank();
  lines.add("measured", "{}", report.source);
  const auto& analysis = report.measurement.shown().analysis;
  add_openings(report, lines);
  if (report.live) add_driver(report, lines);
  if (report.live || analysis.detected) add_gaps(report, lines);
  add_path(analysis, lines);
  if (analysis.detected) add_group_delay(analysis, lines);
  for (auto [heading, texts] : {std::pair{"saved", &report.saved}, {"written", &report.written}})
    for (const auto& text : *texts) lines.add(std::exchange(heading, ""), "{}", text);
  return lines.take();
}

void add_report_options(CLI::App& command, ReportFiles& files, bool folder, bool sound) {
  if (folder)
    command
        .add_option("--folder", files.folder,
                    "folder for the files: the plot, the report as JSON and the recordings")
        ->check(writable_folder());
  command.add_option("--svg", files.picture, "write the plots to this SVG file")->check(writable_file());
  if (sound)
    command
        .add_option("--wav", files.sound,
                    "write the played and the captured signal to this WAV file, for tactus latency analyze")
        ->check(writable_file());
  command.add_flag("--json", files.json, "print the report as JSON");
}

void add_profile_option(CLI::App& command, std::string& profile) {
  command.add_option("--through", profile,
                     "response of the actuator and sensor in the loop, saved by tactus latency calibrate; "
                     "default: none (a cable)");
}

Status write_recording(const std::string& path, const LoopRecording& recording) {
  Samples samples{recording.sample_rate, {recording.played}};
  samples.channels.insert(samples.channels.end(), recording.captured.begin(), recording.captured.end());
  return write_wav(path, samples);
}

int publish(LatencyReport report, const ReportFiles& files) {
  int failed = kDone;
  try {
    if (!files.sound.empty()) write_sounds(report, files.sound);
    if (!files.picture.empty()) write_picture(report, files.picture);
    if (!files.folder.empty()) write_folder(report, files.folder);
  } catch (const CommandError& error) {
    failed = app::report(error);
  }
  files.json ? print_json(json_of(report)) : fmt::print("{}", text_of(report));
  return failed != kDone ? failed : report.ok() ? kDone : kNo;
}

}  // namespace tactus::app
