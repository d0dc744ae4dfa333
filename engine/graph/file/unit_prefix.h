#pragma once

// Thread: [control]

#include <string_view>

namespace tactus {

/// The longest beginning of `text` that reads as a unit inside an expression; "" if there is none. Factors
/// are joined by spaces or by a '/' without spaces around it: "N/m * x" begins with "N/m", "N / m" with "N".
std::string_view unit_prefix(std::string_view text);

}  // namespace tactus
