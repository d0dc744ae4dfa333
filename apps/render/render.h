#pragma once
// Thread: [control]

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/json.h"
#include "apps/play/play_report.h"
#include "backends/take/replay.h"
#include "backends/wav_file.h"
#include "engine/runtime/player.h"

namespace tactus::app {

struct RenderOptions : PlayerOptions {
  std::string replay;              ///< a take's WAV file
  std::string out, sound, events;  ///< files; empty: none
  std::string format = "float";    ///< or "24"
  bool error = false;

  WavEncoding encoding() const { return format == "24" ? WavEncoding::Pcm24 : WavEncoding::Float32; }
};

/// The WAV files and the events of a run, written while it goes on.
class RenderFiles {
 public:
  /// Creates the files. `outputs`: names of the channels; `sounds`: those of the monitor output. Throws a
  /// CommandError: BadFile; BadArgument where --sound finds no monitor output.
  RenderFiles(const RenderOptions& options, const std::vector<std::string>& outputs,
              const std::vector<std::string>& sounds, Hertz sample_rate);

  /// Errors: BadFile.
  [[nodiscard]] Status write(const double* const* outputs, int frames);
  /// Throws a CommandError: BadFile.
  void close(const Json& events);

 private:
  std::string events_;
  std::vector<std::size_t> sounds_;  ///< in the outputs
  std::optional<WavWriter> out_, sound_;
};

/// Runs an instrument on a WAV file or on silence. Gives the exit code, or throws a CommandError.
int render_instrument(const RenderOptions& options, const Target& target);

/// All channels at another rate: see engine/dsp/delays/resample.h.
Samples resample(const Samples& samples, Hertz to);

/// Compiles a version of the graph of a take, unpacked in a temporary folder. Errors: of the texts; BadFile
/// for sound files that have changed.
Checked<std::unique_ptr<Plan>> compile_take(const TakeHeader& header, const TakeFiles& files,
                                            const std::map<std::string, double>& settings);

/// The changes of controls of a take as another graph counts them, by name; those that it does not have are
/// left out, like edits.
std::vector<JournalEntry> journal_for(const Take& take, const Player& engine);
/// Which recorded sensor goes into each input of a graph, by name; -1: none.
std::vector<int> sensors_for(const TakeHeader& header, const std::vector<std::string>& inputs);
/// It can be replayed bit for bit, and it is the same.
bool is_same(const Take& take, const Replayed& replayed);
/// "the drives are the same, bit for bit, for 12.345 s", or where they differ, or why that is unknown.
std::string verdict(const Take& take, const Replayed& replayed);

/// `tactus render --replay`: replays a take and reports whether its drives are the same. Gives the
/// exit code, or throws a CommandError.
int render_take(const RenderOptions& options);

}  // namespace tactus::app
