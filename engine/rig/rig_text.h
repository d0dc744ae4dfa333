#pragma once

// Thread: [control]

#include <string>
#include <string_view>

#include "engine/graph/file/quantity.h"

namespace tactus {

/// A string as TOML writes it, in quotes.
std::string in_quotes(std::string_view text);

/// "V/N": the unit of a sensitivity that is no plain voltage.
std::string volts_per(const Dimension& sensitivity);

/// "\"12.4 ms\"" or 0.6: as people write it where that reads back to the last bit, else all digits in SI.
std::string exact_quantity(double si, const Dimension& dimension);
std::string exact_quantity(const QuantityValue& value);

}  // namespace tactus
