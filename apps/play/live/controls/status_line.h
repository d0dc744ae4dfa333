#pragma once
// Thread: [control]

#include <string>

#include "apps/play/live/session.h"

namespace tactus::app {

/// Two lines, each cut to `columns`:
///   armed | load 1.2, 3.4, 12 % | no xruns | guard: woofer ceiling
///   microphone -23 dB > woofer -6 dB, sound -23 dB | strength = 0.6
/// Loads are the median, the 99.9th percentile and the worst share of a block's time.
std::string status_line(const SessionView& view, const std::string& control, int columns);

/// "-23 dB", and "silent" below -99 dB.
std::string level_text(double peak);
/// "2 xruns (1 input, 1 unsaid), 512 frames lost"; "no xruns".
std::string xrun_text(const Health& health);
/// "1.2 % of a block (p99.9 3.4 %, worst 12 %)".
std::string load_text(const Health& health);

}  // namespace tactus::app
