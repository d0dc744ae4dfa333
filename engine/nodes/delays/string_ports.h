#pragma once

// Thread: [control].

#include "engine/dsp/strings/string_loop.h"
#include "engine/graph/node_type.h"

namespace tactus {

inline InputPort pitch_input(std::string doc) {
  return {
      .name = "pitch", .unit = "Hz", .doc = std::move(doc), .low = StringLoop::kLowestPitch, .high = 20000};
}

inline InputPort loss_input() {
  return {.name = "loss",
          .unit = "",
          .doc = "how much faster high partials die; 0: not at all (one_pole: at most 0.99)",
          .fallback = 0.5,
          .low = 0,
          .high = 1};
}

inline Setting loss_filter_setting() {
  return {.name = "loss_filter",
          .kind = Setting::Kind::Choice,
          .doc = "one_zero takes at most this much away, at half the rate; one_pole darkens from lower down",
          .choices = {"one_zero", "one_pole"},
          .fallback = "one_zero"};
}

/// What the setting says.
inline LossFilter loss_filter_of(const NodeSetup& setup) {
  return setup.setting("loss_filter").text == "one_pole" ? LossFilter::OnePole : LossFilter::OneZero;
}

}  // namespace tactus
