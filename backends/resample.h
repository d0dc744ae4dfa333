#pragma once

#include "backends/wav_file.h"

namespace tactus {

/// [control] The samples at another rate. Each output sample is a sum over the input through a
/// Kaiser-windowed sinc, cut off at the lower of the two Nyquist frequencies: pass band flat within 0.01 dB
/// up to 0.9 of it, images and aliases below −99 dB. The same rate gives the samples back unchanged. Source:
/// J. O. Smith, "Digital Audio Resampling Home Page", 2002.
Samples resample(const Samples& samples, Hertz to);

}  // namespace tactus
