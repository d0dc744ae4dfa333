#pragma once
// Thread: [control]

#include <functional>
#include <memory>

#include "backends/backend.h"

namespace tactus {

/// Streams on two devices at once: a sound card, which brings the blocks, and a joystick, wheel or gamepad,
/// which is read and written by its own thread at its own rate. Channels of a request from kSecondDevice on
/// are those of the second device. What is exchanged carries its time and is interpolated, so that the delay
/// is the same whatever the block size and however late a block comes: `StreamGranted::second`. A value of an
/// output is the mean over a millisecond.
///
/// All else is that of the first device: names, MIDI, a stream without a channel of the second one. When
/// either is lost, the stream is. `clock` [realtime]: seconds, for tests; without one
/// std::chrono::steady_clock.
std::unique_ptr<Backend> make_two_devices(std::unique_ptr<Backend> first, std::unique_ptr<Backend> second,
                                          std::function<double()> clock = {});

}  // namespace tactus
