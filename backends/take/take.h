#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/journal.h"
#include "engine/guard/guarded.h"

namespace tactus {

/// A graph as it was compiled, whatever becomes of its files. Paths are relative to `root`, with '/'.
struct TakeFiles {
  std::string main;                          ///< the file that was played
  std::map<std::string, std::string> texts;  ///< path → text, of it and of all parts
  /// Path → fingerprint of the bytes, of sound files that nodes play: these are not kept in a take.
  std::map<std::string, std::string> sounds;
  std::string root;  ///< where they lay; today's sound files are looked for there
};

/// All that must be known to build again what was played.
struct TakeHeader {
  std::string program;  ///< version of the program that recorded
  Hertz sample_rate = 48_kHz;
  std::vector<std::string> inputs, outputs;  ///< of the guarded processor, in order: the channels of the WAV
  std::vector<std::string> controls;         ///< names, by the number that journal entries use
  TakeFiles files;
  std::map<std::string, double> settings;  ///< start values of controls that differ from the file, SI
  std::vector<std::string> taps;           ///< that the graph was compiled with
  Seconds system_delay;                    ///< that the graph was compiled with
  std::string rig;                         ///< text of the rig file, or empty
  std::vector<std::string> left_out;       ///< ports of the graph that the rig left out
  /// What the rig did to the inputs behind the guard; the WAV holds them as they came from the card.
  std::vector<double> input_scales;  ///< empty: all 1
  int padding_frames = 0;            ///< that inputs were held back for
  std::vector<GuardedChannel> guard;
  bool armed = true;                ///< as Guarded was made
  bool soft_start = true;           ///< false: Guarded::skip_soft_start
  bool trusted_sensors = false;     ///< Guarded::disable_sensor_watch
  std::vector<JournalEntry> state;  ///< Guarded::state when the stream began
};

/// A new version of the graph that took over while it played.
struct TakeEdit {
  std::int64_t frame = 0;  ///< the first that it ran
  TakeFiles files;
  std::map<std::string, double> settings;
  std::vector<std::string> controls;  ///< names by number, with those that came new
};

/// Frames that are silent in the WAV because they could not be recorded.
struct TakeGap {
  std::int64_t frame = 0;
  std::int64_t frames = 0;

  bool operator==(const TakeGap&) const = default;
};

/// The journal beside a WAV.
struct Take {
  TakeHeader header;
  std::vector<JournalEntry> engine, guard;  ///< who applied them; in frame order
  std::vector<TakeEdit> edits;
  std::vector<TakeGap> gaps;
  std::int64_t complete = 0;         ///< everything that was applied before this frame is here
  std::int64_t lost_entries = 0;     ///< entries that are missing
  std::int64_t rounded_sensors = 0;  ///< sensor samples that were no float32
  bool finished = false;             ///< false: the recording was cut off
  std::string ended;                 ///< why it ended before its time, or empty
};

/// [any] "take.wav" → "take.jsonl".
std::filesystem::path journal_path(const std::filesystem::path& wav);

/// [any] What a WAV of float32 keeps of a drive. Below 2^-126 floats are denormals, which a thread may or may
/// not have: there it is 0, or a replay on another thread would differ.
inline float as_recorded(double drive) noexcept {
  constexpr double kSmallest = 1.17549435082228750797e-38;
  return drive < kSmallest && drive > -kSmallest ? 0.0f : static_cast<float>(drive);
}

/// [control] Reads the journal of a take. A line that breaks off at the end is where the recording was cut.
/// Errors: BadFile if there is none, it is none, or a later version of the program wrote it.
Result<Take> read_take(const std::filesystem::path& wav);

/// [any] A line of a journal, as docs/takes.md describes them, with its line end: of a TakeHeader,
/// JournalEntry, TakeGap, TakeEdit or Take. The last says that everything that was applied before
/// `take.complete` is above, except what was lost; if `take.finished`, it is the last line, with the reason
/// why the take ended before its time.
template <class T>
std::string journal_line(const T& value);

/// [any] Why a replay cannot be promised to be the same bit for bit; empty if it can.
std::string why_not_exact(const Take& take);

}  // namespace tactus
