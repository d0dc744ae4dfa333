#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "backends/find_device.h"

namespace tactus {

/// PortAudio between Pa_Initialize and Pa_Terminate: at most one of them in a program, shared by all streams.
class PortAudioSession {
 public:
  /// [control] The one there is, or a new one under this name for JACK. Errors: Device.
  static Result<std::shared_ptr<PortAudioSession>> enter(const std::string& client_name);
  ~PortAudioSession();

  /// [control] As of when the session began.
  std::vector<LibraryDevice> devices() const;
  bool has_jack() const { return has_jack_; }
  /// [control] Before a function that hangs or aborts if the JACK server is gone: is it there? If not, no
  /// function is called any more.
  bool answers();
  /// [control] A stream is open: from now on the state must be queried.
  void occupied(bool yes) { occupied_ = yes; }

 private:
  PortAudioSession();

  bool has_jack_ = false;
  int jack_device_ = -1;  ///< any, if there is one
  bool occupied_ = false;
};

/// [control] Calls PortAudio on a thread that may hang; `call` owns what it touches and returns a PaError.
/// Errors: Device, BadArgument.
Status in_portaudio(std::function<int()> call);
/// [control] May PortAudio be called?
bool portaudio_is_over();
/// [control] No function of PortAudio may be called any more in this program: its JACK server is gone.
void portaudio_lost_jack();

}  // namespace tactus
