#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "apps/cli/backends.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "engine/plot/plot.h"
#include "engine/rig/rig.h"
#include "latency/block_law.h"
#include "latency/calibration.h"
#include "latency/measurement.h"

namespace tactus::app {

/// The report of a measurement. One recorded elsewhere has a single opening without a stream.
struct LatencyReport {
  std::string source;  ///< a device and its setting, or a file
  Measurement measurement;
  bool live = false;                 ///< measured now, on a device
  std::vector<std::string> saved;    ///< where the delay was saved
  std::vector<std::string> written;  ///< files

  bool ok() const { return measurement.finding.verdict == Verdict::Ok; }
  Hertz sample_rate() const;
};

/// What the delay is, in a sentence.
inline constexpr const char* kDelayIs =
    "This is the delay from a voltage at the input to the response at the output if the program responds "
    "within the same block; it includes converters, driver, blocks and cable.";

/// The high-pass of a loop, output and input together, as far as it was found.
struct LoopHighpass {
  std::optional<Hertz> corner;  ///< sum of the corners; nothing: it does not stand out of the error
  double error_hz = 0.0;        ///< standard error
  std::optional<Hertz> bound;   ///< without a corner: it is below this; nothing: not measured
};
LoopHighpass highpass_of(const Analysis& analysis);
/// In a sentence.
std::string highpass_text(const Analysis& analysis);

/// The same of a recording.
inline constexpr const char* kFileDelayIs = "This is the delay from the played to the captured signal.";

/// Part of every report.
Json essentials_json(const DelayEstimate& delay, Hertz sample_rate, const Analysis& analysis);

/// One object, the same keys for every measurement; null is what is not known or not to be trusted.
Json json_of(const LatencyReport& report);
/// Lines for people.
std::string text_of(const LatencyReport& report);
/// A page: impulse response, spectrum, group delay, the delay of every probe.
std::vector<Plot> picture_of(const LatencyReport& report);
/// A page: impulse response, spectrum, group delay of an actuator and a sensor.
std::vector<Plot> picture_of(const Calibration& calibration);

/// With so many digits behind the point; 0 has no sign.
std::string fixed(double value, int digits);
/// "960.0031 ± 0.0004": as many digits as the error leaves.
std::string with_error(double value, double standard_error);
/// "960.0031 ± 0.0004 frames, 20.0001 ms"
std::string delay_text(const DelayEstimate& delay, Hertz sample_rate);
/// "not inverted", "inverted"
const char* polarity_text(int polarity);

// Each adds itself below `tactus latency`.
void add_latency_measure(CLI::App& latency, int& exit_code);
void add_latency_probe(CLI::App& latency, int& exit_code);
void add_latency_analyze(CLI::App& latency, int& exit_code);
void add_latency_sweep(CLI::App& latency, int& exit_code);
void add_latency_calibrate(CLI::App& latency, int& exit_code);

/// Where a report goes, beside stdout.
struct ReportFiles {
  std::string folder;   ///< all of them
  std::string picture;  ///< an SVG
  std::string sound;    ///< what was played and captured
  bool json = false;    ///< stdout is for machines
};

/// --svg and --json, and on request --folder and --wav.
void add_report_options(CLI::App& command, ReportFiles& files, bool folder, bool sound);
/// --through
void add_profile_option(CLI::App& command, std::string& profile);
/// Writes the files, prints the report, and gives the exit code. Throws a CommandError.
int publish(LatencyReport report, const ReportFiles& files);

/// As float32: channel 1 is what was played, then all that was captured. `tactus latency analyze` without a
/// probe reads it back. Errors: BadFile.
Status write_recording(const std::string& path, const LoopRecording& recording);

// `tactus latency sweep`

/// A requested setting and its result.
struct SweepRow {
  SettingDelay setting;          ///< as it was granted
  std::optional<Error> refused;  ///< by the device: nothing was measured
  int asked_block = 0;
  std::optional<int> asked_periods;
  bool again = false;  ///< granted was a setting that another row has
  std::int64_t xruns = 0, lost_frames = 0;
  double detected_lost_frames = 0.0;  ///< by what came back
  std::optional<double> reported_frames;
  Analysis analysis;
};

struct SweepReport {
  std::string source;
  std::vector<SweepRow> rows;
  std::vector<std::string> written;

  /// What was measured, each once.
  std::vector<SettingDelay> settings() const;
  /// The row to play with; without one, the last that was measured; nullptr: none was.
  const SweepRow* recommended() const;
  /// Of each rate and number of periods.
  std::vector<BlockLaw> laws() const;
};

Json json_of(const SweepReport& report);
std::string text_of(const SweepReport& report);
/// Delay against block, with the lines.
Plot picture_of(const SweepReport& report);

/// Which loop is to be measured, and how loud.
struct LoopOptions : DeviceOptions {
  std::optional<int> input, output;  ///< channels of the device, from 1
  std::string rate, level;
  bool shared_port = false;  ///< another program may write to the output too
  bool cable = false;        ///< nothing but a loopback cable is connected to the output
  std::optional<int> block;
  int openings = 5, probes = 8;
  std::string profile;  ///< of what is in the loop, a file; empty: a cable
};

/// Which card, which channels, how loud; on request --rate, --block and --periods, and --openings and
/// --probes.
void add_loop_options(CLI::App& command, LoopOptions& options, bool setting, bool repetitions);

/// A loop that can be measured.
struct Loop {
  ChosenDevices devices;
  MeasureSettings settings;
  std::optional<Rig> rig;  ///< where one was named
};

/// Chooses the devices and looks up what is connected to the output; where neither a rig nor --cable says,
/// it is guarded as a drive of which nothing is known, with a note on stderr. Opens nothing. Throws a
/// CommandError.
Loop make_loop(const LoopOptions& options);

/// Measures with a bar on stderr, beside a StopLoop. Errors: of `measure`. Throws a CommandError when the
/// user ends it: the output has faded out, and the stream is closed. So it does where `another_follows` by
/// itself and the stop inputs were not handled for 5 s.
Result<Measurement> measure_now(Backend& backend, MeasureSettings settings, bool another_follows = false);

/// The profile of a file of `tactus latency calibrate` at `sample_rate`, whatever it was measured at. Throws
/// a CommandError.
PathProfile read_profile(const std::string& file, Hertz sample_rate);

/// "jack:system, 48 kHz, 64 frames a block, 2 periods; output 1 to input 1"
std::string source_text(const MeasureSettings& settings, const StreamGranted& granted);

/// --level in dBFS: "-12", "-12 dB", "-12 dBFS". Throws a CommandError.
double parse_level(const std::string& text);

}  // namespace tactus::app
