#pragma once

// Thread: [control]

#include <filesystem>
#include <string>

namespace tactus::app {

/// `tactus render SCENE --error`: what it is run on, and what is to be different from the file.
struct RenderError {
  std::filesystem::path scene;
  std::string rate, delay, duration;  ///< empty: as the scene says
  bool json = false;
};

/// Prints the errors of one run and its time a frame; gives the exit code.
int render_error(const RenderError& run);

}  // namespace tactus::app
