#pragma once

#include <cstdint>
#include <vector>

#include "engine/dsp/envelopes/stroke_net_kernel.h"

namespace tactus::study {

/// Numbers that a net sees, and whether there is a stroke.
struct Example {
  float levels[TACTUS_STROKE_FEATURES][TACTUS_STROKE_BANDS];
  float after[TACTUS_STROKE_AGES];
  float stroke;  ///< 0 or 1
  float weight;
};

/// A net of `lookahead` frames with weights of He et al. (2015).
tactus_stroke_net first_net(int lookahead, int seed);

/// Trains `from` further: log loss, Adam at `rate`, falling as a cosine, batches of 2048.
tactus_stroke_net train(const tactus_stroke_net& from, const std::vector<Example>& examples, int epochs,
                        double rate);

}  // namespace tactus::study
