#pragma once

// Thread: [control]

#include <string>
#include <vector>

#include "backends/wav_file.h"

namespace tactus::app {

/// Where `tactus render` writes what comes out; empty: nowhere.
struct RenderedFiles {
  std::string out;               ///< all outputs
  std::string sound;             ///< what is to be listened to, alone
  std::string format = "float";  ///< or "24"
};

/// `outputs`: a channel for each of `names`, among them the `sounds` (see sound_names). Errors: BadFile;
/// BadArgument where a sound is asked for and there is none.
Status write_outputs(const RenderedFiles& files, const Samples& outputs,
                     const std::vector<std::string>& names, const std::vector<std::string>& sounds);

}  // namespace tactus::app
