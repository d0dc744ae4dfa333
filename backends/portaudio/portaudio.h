#pragma once

#include "backends/backend.h"

namespace tactus {

/// Sound cards through PortAudio 19: JACK, ALSA and OSS on Linux, CoreAudio on macOS, WASAPI, ASIO and more
/// on Windows. A device is "portaudio:<api>:<its name>".
///
/// Where the request leaves the block out, blocks are as long as the driver's (granted as 0); any other
/// length costs up to one block of delay. ALSA takes the wish and is granted as 0.
///
/// PortAudio cannot leave a JACK server that died: its functions hang or abort the program. So when the
/// server goes, no function of it is called any more, and every later call of this class returns that
/// Error. That concerns streams of other APIs too, opened while a JACK server ran: `granted().comes_back`.
class PortAudioBackend final : public Backend {
 public:
  std::string name() const override { return "portaudio"; }
  /// [control] See Backend::devices. While a stream is open, the list is as of its opening. PortAudio lists
  /// no rates but JACK's.
  Result<std::vector<Device>> devices() override;
  /// [control] See Backend::open. Errors besides: BadArgument for devices of two APIs.
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override;
};

/// [control]
std::unique_ptr<Backend> make_portaudio_backend();

}  // namespace tactus
