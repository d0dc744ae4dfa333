#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <string>

namespace tactus::app {

/// The manual page of the program in man(7) macros, from its commands, options and footers.
std::string man_page(const CLI::App& app);

/// A completion for bash: commands, their options, and files.
std::string bash_completion(const CLI::App& app);

}  // namespace tactus::app
