#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "engine/core/units.h"
#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/quantity.h"

namespace tactus {

/// The latest time that a file may name: a day.
inline constexpr double kLongestTime_s = 86400;

/// A quantity called `key` of any unit; nothing if it is left out or wrong.
std::optional<QuantityValue> read_any(const Value::Table& table, std::string_view key, Mistakes& mistakes);
/// A quantity called `key` from `low` to `high` (SI); nothing if it is left out or wrong.
std::optional<double> read_bounded(const Value::Table& table, const std::string& key, const std::string& unit,
                                   double low, double high, Mistakes& mistakes);
/// `from` and `to` of what is looked at, within `duration` (0: a day), in this order.
std::pair<std::optional<double>, std::optional<double>> read_window(const Value::Table& table,
                                                                    Seconds duration, Mistakes& mistakes);
/// A whole number, likewise.
std::optional<double> read_whole(const Value::Table& table, const std::string& key, double low, double high,
                                 Mistakes& mistakes);

}  // namespace tactus
