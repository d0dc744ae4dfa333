#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "engine/core/error.h"
#include "engine/core/units.h"

namespace tactus {

/// What a delay belongs to. With another block or number of periods the same card has another delay.
struct DelayKey {
  std::string input, output;  ///< Device::id
  Hertz sample_rate;
  int block_frames = 0;
  int periods = 0;  ///< 0: not known

  bool operator==(const DelayKey&) const = default;
};

/// [any] The key of the delay of a stream.
DelayKey key_of(const StreamGranted& granted);

/// A delay from sensor volts to actuator volts, measured on this machine.
struct MeasuredDelay {
  DelayKey key;
  Seconds delay;
  std::optional<Seconds> spread;  ///< between sessions
  std::string when;               ///< "2026-11-21T19:12:20Z"
};

/// The delays that were measured on this machine, in one file for all of them.
class MeasuredDelays {
 public:
  /// [control] No file is an empty store. A file that cannot be understood is set aside under another name,
  /// which `load_error` contains; nothing in it is lost.
  static MeasuredDelays load(const std::filesystem::path& file = default_file());

  /// [any] The newest whose key `fits`; nullptr if there is none.
  const MeasuredDelay* newest(const std::function<bool(const DelayKey&)>& fits) const;
  /// [any] The same of one key.
  const MeasuredDelay* find(const DelayKey& key) const {
    return newest([&](const DelayKey& other) { return other == key; });
  }
  const std::vector<MeasuredDelay>& all() const { return delays_; }
  const std::optional<Error>& load_error() const { return load_error_; }

  /// [control] Adds one, in the place of the last of the same key, and writes the file: whole or not at all.
  /// What another program wrote since `load` stays. Errors: BadFile.
  Status save(MeasuredDelay delay);

  /// [control] $XDG_STATE_HOME/tactus/delays.json, by default in ~/.local/state; elsewhere
  /// %LOCALAPPDATA%\tactus. Empty if the system says nothing.
  static std::filesystem::path default_file();

 private:
  std::filesystem::path file_;
  std::vector<MeasuredDelay> delays_;
  std::optional<Error> load_error_;
};

}  // namespace tactus
