#pragma once

namespace tactus {

/// [any] JACK prints what also comes back as an error, and the libraries below RtAudio and PortAudio a line
/// for each device of their configuration that is not there, a hundred on a computer without a card. What
/// matters comes back as an Error; the rest is not printed any more.
void silence_library_logs();

}  // namespace tactus
