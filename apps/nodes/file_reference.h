#pragma once

#include <string>

namespace tactus {

/// [control] The keys of all files and the measures of scenes, as the end of docs/nodes.md.
std::string file_reference();

}  // namespace tactus
