#pragma once

// Thread: [control]

#include <string>

#include "engine/core/dimension.h"
#include "engine/core/error.h"
#include "engine/graph/file/value.h"

namespace tactus {

/// A number (bare) or a quantity in a string, as written in a graph file.
Result<QuantityValue> read_quantity(const Value& value);
/// The same in SI, checked against what is `expected`: "'12 mm' is in m, but 'time' is in s; give a time …".
Result<double> read_quantity(const Value& value, const Unit& expected, const std::string& what);

/// "1234.5", "1e-09": the shortest text that reads well in a message.
std::string short_number(double number);
/// "15 ms" for 0.015 s: in the unit that people would choose for it; a plain number without one.
std::string short_quantity(double si, const Dimension& dimension);
/// The same for a value whose unit may be decibels: "-34 dB", "0.012 m".
std::string in_unit(double si, const Unit& unit);
/// "it runs from 0 s to 10 s", "it must be at least 0 s": a remedy for a value outside its range.
std::string limits_text(double low, double high, const Unit& unit);
/// "in m", "a plain number"
std::string unit_phrase(const Dimension& dimension);

}  // namespace tactus
