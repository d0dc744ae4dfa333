#include "apps/study/sweep_range.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
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

/// `count` numbers from the first, in the unit that was written.
Result<std::vector<ControlValue>> spread(const Written& written, double step, double count,
                                         const std::string& option) {
  if (!(count >= 1 && count <= kMostValues))
    return fail(Errc::OutOfRange, option, fmt::format("{:g} values cannot be swept", count),
                fmt::format("choose 1 to {:g}", kMostValues));
  std::vector<ControlValue> values;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    // A number as it would be written: 0.3, not 0.1 + 0.2.
    const auto number = fmt::format("{:.12g}", written.numbers[0] + i * step);
    const auto value = parse_quantity(number + " " + written.unit);
    if (!value) return fail(Errc::Syntax, option, "'" + written.unit + "' is not a unit", "");
    values.push_back(written.unit.empty() ? ControlValue{value->si}
                                          : ControlValue{value->si, value->unit.dimension});
  }
  return values;
}

}  // namespace

Result<std::vector<ControlValue>> parse_steps(const std::string& text, const std::string& option) {
  const auto* remedy = "write FROM:TO:STEP, as in \"0:40:1 ms\"";
  const auto written = read(text, option, remedy);
  if (!written) return tl::unexpected(written.error());
  const auto& numbers = written->numbers;
  if (numbers.size() == 1) return spread(*written, 0, 1, option);
  if (numbers.size() != 3 || !(numbers[2] > 0) || numbers[1] < numbers[0])
    return unreadable(text, option, remedy);
  return spread(*written, numbers[2], std::floor((numbers[1] - numbers[0]) / numbers[2] + 1e-9) + 1, option);
}

Result<std::vector<ControlValue>> parse_spread(const std::string& text, const std::string& option) {
  const auto* remedy = "write FROM:TO:COUNT, as in \"0.2:1:5\"";
  const auto written = read(text, option, remedy);
  if (!written) return tl::unexpected(written.error());
  const auto& numbers = written->numbers;
  if (numbers.size() == 1) return spread(*written, 0, 1, option);
  if (numbers.size() != 3 || numbers[2] != std::floor(numbers[2])) return unreadable(text, option, remedy);
  const double step = numbers[2] > 1 ? (numbers[1] - numbers[0]) / (numbers[2] - 1) : 0;
  return spread(*written, step, numbers[2], option);
}

}  // namespace tactus::app
