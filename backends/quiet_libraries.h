#pragma once

namespace tactus {

/// [any] The libraries below RtAudio and PortAudio print a line for each device of their configuration that
/// is not there, a hundred on a computer without a card. What matters comes back as an Error; the rest is not
/// printed any more.
void silence_sound_libraries();

}  // namespace tactus
