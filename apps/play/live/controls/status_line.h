#pragma once
// Thread: [control]

#include <string>

#include "apps/play/live/controls/live_controls.h"
#include "apps/play/live/session.h"

namespace tactus::app {

/// One line of at most `columns` characters:
///   armed | rec 12 s | guard: woofer ceiling | load 3 % (max 12 %) | microphone [#####...] > woofer
///   [########] | strength = 0.6
/// A bar has one `#` for each 48/N dB of its N cells above -48 dB, and `!` in the last at full scale. Where
/// columns are few, names and bars become shorter, and then inputs and outputs have one bar each. The load is
/// the share of a block's time that computing it takes: the 99.9th percentile, and the maximum.
std::string status_line(const SessionView& view, const std::string& control, int columns);

/// A line for each control, at most `rows` of them around the selected one: its name, where it is in its
/// range, and its value. Those that cannot be changed during playback are marked "constant".
std::string control_list(const LiveControls& controls, std::size_t selected, int columns, int rows);

/// "-23 dB", and "silent" below -99 dB.
std::string level_text(double peak);
/// "2 xruns (1 input, 1 unsaid), 512 frames lost"; "no xruns".
std::string xrun_text(const Health& health);
/// "1.2 % of a block (p99.9 3.4 %, worst 12 %)".
std::string load_text(const Health& health);

}  // namespace tactus::app
