#pragma once

#include <string>
#include <vector>

#include "backends/backend.h"

namespace tactus {

/// A device and where RtAudio has it now; the index changes whenever devices come and go.
struct RtAudioDevice {
  Device device;
  std::string api;   ///< RtAudio's name of it: "jack", "alsa"
  std::string name;  ///< RtAudio's name of it, which two devices may have
  unsigned index = 0;
};

/// [control] Every device that can be opened now, or those of one API alone where `text` begins like an id of
/// it. Errors: Device when an API does not answer and no other has a device.
Result<std::vector<RtAudioDevice>> rtaudio_devices(const std::string& text = "");

}  // namespace tactus
