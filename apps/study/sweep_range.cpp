#include "apps/study/sweep_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <sstream>

#include "engine/core/dimension.h"

namespace tactus::app {
namespace {

constexpr double kMostValues = 10000;

/// Numbers with the one unit that stands behind some of them.
struct Written {
  std::vector<double> numbers;
  std::string unit;
};

tl::unexpected<Error> unreadable(const std::string& text, const std::string& option,
                                 const std::string& remedy) {
  return fail(Errc::Syntax, option, "'" + text + "' is no range", remedy);
}

Result<Written> read(const std::string& text, const std::string& option, const std::string& remedy) {
  Written written;
  std::istringstream parts{text};
  for (std::string part; std::getline(parts, part, ':');) {
    char* end = nullptr;
    written.numbers.push_back(std::strtod(part.c_str(), &end));
    if (end == part.c_str() || !std::isfinite(written.numbers.back()))
      return unreadable(text, option, remedy);
    while (*end == ' ') ++end;
    const std::string unit{end};
    if (unit.empty()) continue;
    if (!written.unit.empty() && written.unit != unit)
      return fail(Errc::UnitMismatch, option, "'" + text + "' has the units " + written.unit + " and " + unit,
                  "write all in one unit");
    written.unit = unit;
  }
  return written;
}

/// `count` numbers, number_of(0) and so on, in the unit that was written.
Result<std::vector<ControlValue>> spread(const Written& written, double count, const std::string& option,
                                         const std::function<double(int)>& number_of) {
  if (!(count >= 1 && count <= kMostValues))
    return fail(Errc::OutOfRange, option, fmt::format("{:g} values cannot be swept", count),
                fmt::format("choose 1 to {:g}", kMostValues));
  std::vector<ControlValue> values;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    // A number as it would be written: 0.3, not 0.1 + 0.2.
    const auto number = fmt::format("{:.12g}", number_of(i));
    const auto value = parse_quantity(number + " " + written.unit);
    if (!value) return fail(Errc::Syntax, option, "'" + written.unit + "' is not a unit", "");
    values.push_back(written.unit.empty() ? ControlValue{value->si}
                                          : ControlValue{value->si, value->unit.dimension});
  }
  return values;
}

/// From the first number on by equal steps.
Result<std::vector<ControlValue>> evenly(const Written& written, double step, double count,
                                         const std::string& option) {
  return spread(written, count, option, [&](int i) { return written.numbers[0] + i * step; });
}

/// Takes ":log" away: "0.2:3.2:7:log", "55:880:9:log Hz".
bool take_log(std::string& text) {
  static const std::string kLog = ":log";
  const auto found = text.find(kLog);
  if (found == std::string::npos) return false;
  const auto rest = text.substr(found + kLog.size());
  if (!rest.empty() && rest.front() != ' ') return false;
  text = text.substr(0, found) + rest;
  return true;
}

}  // namespace

Result<std::vector<ControlValue>> parse_steps(const std::string& text, const std::string& option) {
  const auto* remedy = "write FROM:TO:STEP, as in \"0:40:1 ms\"";
  const auto written = read(text, option, remedy);
  if (!written) return tl::unexpected(written.error());
  const auto& numbers = written->numbers;
  if (numbers.size() == 1) return evenly(*written, 0, 1, option);
  if (numbers.size() != 3 || !(numbers[2] > 0) || numbers[1] < numbers[0])
    return unreadable(text, option, remedy);
  return evenly(*written, numbers[2], std::floor((numbers[1] - numbers[0]) / numbers[2] + 1e-9) + 1, option);
}

Result<std::vector<ControlValue>> parse_spread(const std::string& text, const std::string& option) {
  const auto* remedy = "write FROM:TO:COUNT, as in \"0.2:1:5\", or FROM:TO:COUNT:log";
  auto range = text;
  const bool by_factors = take_log(range);
  const auto written = read(range, option, remedy);
  if (!written) return tl::unexpected(written.error());
  const auto& numbers = written->numbers;
  if (numbers.size() == 1 && !by_factors) return evenly(*written, 0, 1, option);
  if (numbers.size() != 3 || numbers[2] != std::floor(numbers[2])) return unreadable(text, option, remedy);
  const double intervals = std::max(1.0, numbers[2] - 1);
  if (!by_factors) return evenly(*written, (numbers[1] - numbers[0]) / intervals, numbers[2], option);
  if (!(numbers[0] * numbers[1] > 0))
    return fail(Errc::OutOfRange, option, "'" + text + "' cannot go up by equal factors",
                "choose both ends above 0, or leave ':log' out");
  const double ratio = numbers[1] / numbers[0];
  return spread(*written, numbers[2], option,
                [&](int i) { return numbers[0] * std::pow(ratio, i / intervals); });
}

}  // namespace tactus::app
