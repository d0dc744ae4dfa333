#pragma once

#include "engine/scene/file/scene_spec.h"
#include "tests/support/temporary_folder.h"

namespace tactus::test {

/// A scene from text; errors in it are errors.
inline Checked<SceneSpec> parse_scene(std::string_view text, const std::string& file_name,
                                      const std::filesystem::path& root = {}) {
  auto loaded = parse_scene_leniently(text, file_name, root);
  if (!loaded.errors.empty()) return tl::unexpected(std::move(loaded.errors));
  return std::move(*loaded.scene);
}

/// A folder with an instrument and a plant, for scenes that join them.
struct SceneFolder : TemporaryFolder {
  SceneFolder() {
    write("instrument.toml", R"(format = 1
[inputs]
mic = { unit = "full scale" }
pedal = { unit = "full scale" }
[controls]
strength = { value = 0.5, range = [0, 1] }
[nodes]
hit = { type = "onset", in = "mic", threshold = 0.1, hold = "15 ms" }
[outputs]
woofer = { from = "strength * hit" }
)");
    write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
lift = { unit = "m" }
[outputs]
mic = { from = "drive" }
stick = { from = "lift", unit = "m" }
)");
  }
};

}  // namespace tactus::test
