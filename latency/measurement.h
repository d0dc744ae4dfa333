#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "latency/estimation/analysis.h"
#include "latency/estimation/loop_recording.h"

namespace tactus {

/// What to measure, and how long.
struct MeasureSettings {
  StreamRequest request;        ///< device, rate, block, periods; its channels and maps are not used
  int input = 0, output = 0;    ///< channels of the device, from 0 on; all inputs are listened to
  GuardedChannel guard;         ///< what hangs on the output
  bool watch_sensors = true;    ///< false: an input may be silent or repeat itself, as a digital cable does
  double softest_dbfs = -50.0;  ///< where the level begins
  double loudest_dbfs = -6.0;   ///< and where it may end, however little is captured
  int openings = 5;             ///< of the stream, one after another
  int probes = 8;               ///< each time
  std::optional<PathProfile> profile;
  bool shared_port = false;                          ///< another program may write to the output's port too
  const DeadMansSwitch* dead_mans_switch = nullptr;  ///< of the program that plays the probes; nullptr: none
  /// What an earlier measurement was granted on the device; with another device this one ends. Settings may
  /// differ. Nothing: the first opening decides.
  std::optional<StreamGranted> previous;
};

/// One opening of the stream.
struct Opening {
  StreamGranted granted;
  Health health;
  double level_dbfs = 0.0;  ///< of the probes
  LoopRecording recording;
  Analysis analysis;
  Finding finding;  ///< of the analysis, or why there was nothing to analyse
};

/// All of them, and the mean of their delays.
struct Measurement : DelayEstimate {
  std::vector<Opening> openings;          ///< at least one
  double spread_frames = 0.0;             ///< standard deviation over openings
  std::optional<double> reported_frames;  ///< by the driver: input and output together

  /// [any] The opening that shows best what was found: the first with the verdict of the whole.
  const Opening& shown() const;
};

/// Called with the share that is done and what is being done, many times a second. May throw to put an end to
/// it: the stream is then stopped.
using MeasureProgress = std::function<void(double share, const std::string& what)>;

/// [control] With what `measure` opens the stream: the one output and all inputs of the device, as it is now.
/// Errors: of Backend::devices; UnknownName for the device.
Result<StreamRequest> measurement_request(Backend& backend, const MeasureSettings& settings);

/// [control] Before a further opening. Errors: Device if the stop inputs were not handled for 5 s.
Status check_attended(const DeadMansSwitch& dead_man);

/// [control] Opens the device again and again: silence, the level, probes, the pilot. Whatever goes wrong
/// with the path is a finding. What another opening would not cure ends it. Errors: BadArgument and
/// OutOfRange for settings that make no sense; those of Backend::open and Stream::start; Device when it goes
/// away, when a later opening has another device or other settings than the first one, and when the stop
/// inputs were not handled for 5 s before a later opening (the program was stopped).
Result<Measurement> measure(Backend& backend, const MeasureSettings& settings,
                            const MeasureProgress& progress = {});

}  // namespace tactus
