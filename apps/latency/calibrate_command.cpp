#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <filesystem>

#include "apps/latency/latency.h"
#include "engine/core/files.h"
#include "engine/scene/file/path_file.h"
#include "latency/calibration.h"
#include "latency/measured.h"

namespace tactus::app {
namespace {

struct CalibrateOptions {
  LoopOptions loop;
  std::string electrical, out;
  ReportFiles report;
};

/// The card's own delay [frames]: given by the user or the rig, or measured here.
double electrical_frames(const CalibrateOptions& options, const Loop& loop, const StreamGranted& granted) {
  const auto rate = granted.format.sample_rate;
  if (!options.electrical.empty()) return parse_option(options.electrical, "s", "electrical") * rate.value;
  if (loop.rig && loop.rig->measured_delay) return frames_in(*loop.rig->measured_delay, rate);
  const auto delays = MeasuredDelays::load();
  if (const auto* found = delays.find(key_of(granted))) return frames_in(found->delay, rate);
  exit_with({Errc::Missing, "--electrical",
             "the delay of the card alone has not been measured with this sample rate and block size",
             "measure it with a loopback cable (tactus latency measure), or give it"});
}

Json json_of(const Calibration& calibration, Hertz rate) {
  const auto& profile = calibration.profile;
  // The swing begins somewhere within a frame.
  const double error = std::hypot(calibration.standard_error_frames, 1.0 / std::sqrt(12.0));
  auto json = essentials_json({calibration.finding, calibration.arrival_frames, error}, rate, calibration);
  json["delay_is"] =
      "from the drive signal to the first swing of the captured signal, without the delay of the card";
  if (profile.taps.empty()) return json;
  const auto octave_json = [&](const BandDelay& octave) -> Json {
    return {{"centre_hz", octave.centre_hz},
            {"delay_frames", octave.delay_frames},
            {"delay_ms", 1e3 * octave.delay_frames / rate.value},
            {"standard_error_frames", octave.standard_error_frames}};
  };
  const auto& resonance = calibration.resonance;
  json.update({{"low_hz", profile.low.value},
               {"high_hz", profile.high.value},
               {"resonance_hz", known(resonance.has_value(), resonance ? resonance->frequency_hz : 0)},
               {"resonance_q", known(resonance.has_value(), resonance ? resonance->q : 0)},
               {"unexplained", calibration.unexplained},
               {"group_delay", list_of(calibration.group_delay, octave_json)}});
  return json;
}

void print(const Calibration& calibration, Hertz rate) {
  const auto& finding = calibration.finding;
  if (finding.verdict != Verdict::Ok)
    return fmt::print("no profile      {}\ncause           {}\nremedy          {}\n", code(finding.verdict),
                      finding.what, finding.remedy);
  fmt::print("arrival         {:.3f} ms after the delay of the card alone, {}\n",
             1e3 * calibration.arrival_frames / rate.value, polarity_text(calibration.polarity));
  fmt::print("measured band   {:.0f} Hz to {:.0f} Hz\n", calibration.profile.low.value,
             calibration.profile.high.value);
  if (calibration.resonance)
    fmt::print("resonance       {:.1f} Hz, Q {:.2f}\n", calibration.resonance->frequency_hz,
               calibration.resonance->q);
  fmt::print("noise           {:.1f} dB below the probes\nunexplained     {:.2g} of the captured signal\n",
             calibration.snr_db, calibration.unexplained);
  fmt::print("group delay    ");
  for (const auto& octave : calibration.group_delay) fmt::print(" {:>9.0f} Hz", octave.centre_hz);
  fmt::print("\n               ");
  for (const auto& octave : calibration.group_delay)
    fmt::print(" {:>9.3f} ms", 1e3 * octave.delay_frames / rate.value);
  fmt::print("\n");
}

std::string description_of(const Calibration& calibration, const std::string& device) {
  const auto& profile = calibration.profile;
  auto text = fmt::format(
      "Measured {} on {} at {:g} kHz: valid from {:.0f} Hz to {:.0f} Hz, arrives after {:.3f} ms, {}",
      fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr))), device, profile.sample_rate.value / 1e3,
      profile.low.value, profile.high.value, 1e3 * calibration.arrival_frames / profile.sample_rate.value,
      polarity_text(calibration.polarity));
  if (const auto& resonance = calibration.resonance)
    text += fmt::format(", resonance {:.1f} Hz, Q {:.2f}", resonance->frequency_hz, resonance->q);
  return text + ".";
}

int run_latency_calibrate(const CalibrateOptions& options) {
  const auto loop = make_loop(options.loop);
  install_signal_handlers();
  const auto measured = measure_now(*loop.devices.backend, loop.settings);
  if (!measured) exit_with(measured.error(), exit_of(measured.error()));
  const auto& opening = measured->openings.front();
  const auto rate = opening.granted.format.sample_rate;
  Calibration calibration{opening.analysis};
  calibration.finding = opening.finding;
  if (!spoils(opening.finding.verdict))
    calibration = or_exit(calibrate(opening.recording,
                                    {loop.settings.input, electrical_frames(options, loop, opening.granted)}),
                          kUsage);
  const auto& [folder, picture, sound, as_json] = options.report;
  as_json ? print_json(json_of(calibration, rate)) : print(calibration, rate);
  const auto& profile = calibration.profile;
  if (!sound.empty()) or_exit(write_recording(sound, opening.recording));
  if (!picture.empty() && !profile.taps.empty()) or_exit(write_svg(picture, picture_of(calibration)));
  if (calibration.finding.verdict != Verdict::Ok) return kNo;
  // A graph that scenes can use, with what was measured, on which device.
  const PathFile path{std::filesystem::path{options.out}.stem().string(),
                      description_of(calibration, opening.granted.device), "tactus latency calibrate",
                      profile.sample_rate, profile.taps};
  or_exit(write_file(options.out, to_text(path)));
  fmt::print(stderr, "{} is written\n", options.out);
  return kDone;
}

}  // namespace

void add_latency_calibrate(CLI::App& latency, int& exit_code) {
  auto [command, options] =
      add_command(latency, "calibrate", "Measure the combined response of an actuator and a sensor",
                  exit_code, run_latency_calibrate);
  auto& loop = options.loop;
  loop.openings = 1;
  add_loop_options(command, loop, true, false);
  command.add_option("--electrical", options.electrical,
                     "delay of the card without actuator and sensor, such as \"3.92 ms\"; default: from the "
                     "rig, or from the last measurement on this computer");
  command
      .add_option("--out", options.out,
                  "file to write: the response, as a graph file that a scene can use as its plant")
      ->check(writable_file())
      ->required();
  add_report_options(command, options.report, false, true);
  command.footer(
      "Examples:\n  tactus latency measure --rig desk.toml                          # first, with a loopback "
      "cable\n  tactus latency calibrate --rig desk.toml --out woofer.toml      # then through woofer and "
      "microphone\n  tactus latency measure --rig desk.toml --through woofer.toml    # later, without a "
      "cable\nThe actuator on the rig's first output moves, up to the limits of its guard: keep hands away.");
}

}  // namespace tactus::app
