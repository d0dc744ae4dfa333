#include "apps/render/resample.h"

#include <cmath>

#include "engine/dsp/delays/resample.h"

namespace tactus::app {

Samples resample(const Samples& samples, Hertz to) {
  if (to == samples.sample_rate) return samples;
  const auto frames = std::llround(static_cast<double>(samples.frames()) / (samples.sample_rate / to));
  Samples result{to, {}};
  for (const auto& channel : samples.channels)
    result.channels.push_back(tactus::resample(channel, samples.sample_rate, to, 0, frames));
  return result;
}

}  // namespace tactus::app
