#pragma once

// Thread: [control]

#include <span>
#include <string>
#include <string_view>

namespace tactus {

/// The candidate with the fewest letters to change, if that is few enough to be what was meant; else "".
std::string nearest_name(std::string_view wrong, std::span<const std::string> candidates);

}  // namespace tactus
