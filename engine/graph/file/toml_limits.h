#pragma once

// Thread: [control]

#include <cstddef>
#include <string_view>

#include "engine/core/error.h"
#include "engine/graph/file/source.h"

namespace tactus {

inline constexpr std::size_t kMaxFileBytes = 16u << 20;
inline constexpr std::size_t kMaxTomlDepth = 64;
inline constexpr std::size_t kMaxTomlValues = 250'000;

/// What a text must satisfy before a recursive TOML parser may see it: at most 16 MB, valid UTF-8, brackets
/// and dots of keys at most 64 deep, at most 250000 values (counted by '=', commas and '['). Errors: Syntax,
/// with the place.
Status check_toml_limits(std::string_view text, const Source& file);

}  // namespace tactus
