#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "apps/cli/backends.h"
#include "apps/cli/console.h"
#include "engine/rig/rig.h"
#include "latency/measurement.h"

namespace tactus::app {

/// Which loop is to be measured, and how loud.
struct LoopOptions {
  std::string backend, device, input_device, rig;
  std::optional<int> input, output;  ///< channels of the device, from 1
  std::string rate, level;
  std::optional<int> block, periods;
  int openings = 5, probes = 8;
  std::string profile;  ///< of what is in the loop, a file; empty: a cable
};

/// --backend to --level: which card, which channels, how loud.
void add_loop_options(CLI::App& command, LoopOptions& options);
/// --rate, --block and --periods: one setting.
void add_setting_options(CLI::App& command, LoopOptions& options);

/// --openings and --sweeps
void add_repetition_options(CLI::App& command, LoopOptions& options);

/// A loop that can be measured.
struct Loop {
  ChosenDevices devices;
  MeasureSettings settings;
  std::optional<Rig> rig;  ///< where one was named
};

/// Chooses the devices and looks up what is connected to the output. Opens nothing. Throws a CommandError.
Loop make_loop(const LoopOptions& options);

/// Measures with a bar on stderr. Errors: of `measure`. Throws a CommandError when the user interrupts it
/// (after install_signal_handlers); the stream is closed.
Result<Measurement> measure_now(Backend& backend, const MeasureSettings& settings);

/// The profile of a file of `tactus latency calibrate` at `sample_rate`, whatever it was measured at. Throws
/// a CommandError.
PathProfile read_profile(const std::string& file, Hertz sample_rate);

/// "jack:system, 48 kHz, 64 frames a block, 2 periods; output 1 to input 1"
std::string source_text(const MeasureSettings& settings, const StreamGranted& granted);

/// --level in dBFS: "-12", "-12 dB", "-12 dBFS". Throws a CommandError.
double parse_level(const std::string& text);

}  // namespace tactus::app
