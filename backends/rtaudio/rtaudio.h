#pragma once

#include "backends/backend.h"

namespace tactus {

/// Sound cards through RtAudio 5: JACK, ALSA and PulseAudio on Linux, CoreAudio on macOS, WASAPI and ASIO on
/// Windows, whatever the library was compiled for. A device is "rtaudio:<api>:<its name>".
///
/// With JACK the server chooses the block, and RtAudio hands over input that is one block old. A change of
/// the server's block size ends the stream for good (Lost): RtAudio cannot go on, but opening it again works.
class RtAudioBackend final : public Backend {
 public:
  std::string name() const override { return "rtaudio"; }
  /// [control] See Backend::devices. The default device is that of the first API that has one.
  Result<std::vector<Device>> devices() override;
  /// [control] See Backend::open. Errors besides: BadArgument for devices of two APIs.
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override;
};

/// [control]
std::unique_ptr<Backend> make_rtaudio_backend();

}  // namespace tactus
