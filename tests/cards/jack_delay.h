#pragma once

#include <memory>
#include <string>

#include "tests/support/child_process.h"
#include "tests/support/sound_server.h"

namespace tactus::test {

/// `jack_delay` by F. Adriaensen, in a process of its own: five tones go out of its one port, and the phases
/// in which they come in at the other tell the delay modulo 65,536 frames. Four times a second it says what
/// it found, to a thousandth of a frame.
class JackDelay {
 public:
  ~JackDelay();

  /// The median of the next so many readings.
  double frames(int readings);

 private:
  friend std::unique_ptr<JackDelay> start_jack_delay(SoundServer& server, const std::string& playback,
                                                     const std::string& capture);
  JackDelay() = default;

  std::unique_ptr<ChildProcess> process_;
};

/// Measures from one port of the server to another, from now on. nullptr: it is not installed, and the test's
/// output says so.
std::unique_ptr<JackDelay> start_jack_delay(SoundServer& server, const std::string& playback,
                                            const std::string& capture);

}  // namespace tactus::test
