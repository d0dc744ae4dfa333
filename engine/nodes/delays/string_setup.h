#pragma once

// Thread: [control].

#include "engine/dsp/strings/string_loop.h"
#include "engine/graph/node_type.h"

namespace tactus {

inline InputPort pitch_input(std::string doc) {
  return {"pitch", "Hz", std::move(doc), {}, StringLoop::kLowestPitch, 20000};
}
inline LossFilter loss_filter_of(const NodeSetup& setup) {
  return setup.setting("loss_filter").text == "one_pole" ? LossFilter::OnePole : LossFilter::OneZero;
}

}  // namespace tactus
