#pragma once

// Thread: [control].

#include <algorithm>

#include "engine/dsp/strings/string_loop.h"
#include "engine/graph/node_type.h"

namespace tactus {

inline InputPort pitch_input(std::string doc) {
  return {"pitch", "Hz", std::move(doc), {}, StringLoop::kLowestPitch, StringLoop::kHighestPitch};
}
/// What a signal may ask for, within the range that it is clamped to.
inline Interval pitches_of(const NodeSetup& setup) {
  const auto& asked = setup.input("pitch").range;
  const auto clamped = [](double pitch) {
    return std::clamp(pitch, StringLoop::kLowestPitch, StringLoop::kHighestPitch);
  };
  return {clamped(asked.low), clamped(asked.high)};
}
inline LossFilter loss_filter_of(const NodeSetup& setup) {
  return setup.setting("loss_filter").text == "one_pole" ? LossFilter::OnePole : LossFilter::OneZero;
}

}  // namespace tactus
