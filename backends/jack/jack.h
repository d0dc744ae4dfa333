#pragma once

#include <memory>
#include <string>
#include <vector>

#include "backends/backend.h"

namespace tactus {

/// The running JACK server, or PipeWire in its place: the default one, or that of $JACK_DEFAULT_SERVER. Every
/// client that has audio ports is a device: "jack:system" is the sound card. The server decides rate and
/// block size for all: another rate is refused, another block is not granted. This never starts a server.
///
/// A stream is Lost when the server or the device's ports go away, and Stalled while the server does not
/// answer. Changes that others make to its connections are kept, and reported by `take_note`. A call that
/// the server does not answer within two seconds is an error; what hangs is left to itself, silent.
class JackBackend final : public Backend {
 public:
  std::string name() const override { return "jack"; }
  Result<std::vector<Device>> devices() override;
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override;
};

/// [control]
std::unique_ptr<Backend> make_jack_backend();

}  // namespace tactus
