#pragma once
// Thread: [control]

#include <memory>
#include <string>
#include <vector>

#include "backends/backend.h"

namespace tactus {

/// A backend for sound cards that this program was built with. The table is in
/// cmake/TactusDependencies.cmake; the folder backends/NAME defines `make_NAME_backend`.
struct SoundBackend {
  std::string name;  ///< Backend::name
  std::unique_ptr<Backend> (*make)();
};

/// In the order in which they are asked for a device.
const std::vector<SoundBackend>& sound_backends();

}  // namespace tactus
