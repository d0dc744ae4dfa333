#pragma once
// Thread: [control]

#include <string>

#include "apps/play/play_report.h"
#include "backends/wav_file.h"

namespace tactus::app {

struct RenderOptions : RunOptions {
  std::string replay;                  ///< a take's WAV file
  std::string in, out, sound, events;  ///< files; empty: none
  std::string format = "float";        ///< or "24"
  bool error = false;

  WavEncoding encoding() const { return format == "24" ? WavEncoding::Pcm24 : WavEncoding::Float32; }
};

/// All channels at another rate: see engine/dsp/delays/resample.h.
Samples resample(const Samples& samples, Hertz to);

/// `tactus render --replay`: replays a take and reports whether its drives are the same. Gives the
/// exit code, or throws a CommandError.
int render_take(const RenderOptions& options);

}  // namespace tactus::app
