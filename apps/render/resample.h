#pragma once

#include "backends/wav_file.h"

namespace tactus::app {

/// [control] All channels at another rate: see engine/dsp/delays/resample.h.
Samples resample(const Samples& samples, Hertz to);

}  // namespace tactus::app
