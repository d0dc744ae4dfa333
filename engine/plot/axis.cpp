#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "engine/plot/layout.h"

namespace tactus::plot {
namespace {

constexpr std::array<std::string_view, 15> kSymbols = {"m",  "s", "Hz",  "N", "V", "A", "W", "J",
                                                       "Pa", "g", "ohm", "F", "H", "T", "C"};
constexpr std::array<std::string_view, 9> kPrefixes = {"p", "n", "µ", "m", "",
                                                       "k", "M", "G", "T"};  // 10^-12 …

/// Whether a prefix before `unit` prefixes its first symbol and nothing else: not m^2.
bool takes_prefix(const std::string& unit) {
  const auto first = std::string_view{unit}.substr(0, unit.find_first_of(" /*^"));
  const bool power = first.size() < unit.size() && unit[first.size()] == '^';
  return !power && std::ranges::find(kSymbols, first) != kSymbols.end();
}

/// "m/s^2" as printed.
std::string pretty(std::string unit) {
  const auto replace = [&](std::string_view from, std::string_view to) {
    for (auto at = unit.find(from); at != std::string::npos; at = unit.find(from, at + to.size()))
      unit.replace(at, from.size(), to);
  };
  replace("^2", "²");
  replace("^3", "³");
  replace("ohm", "Ω");
  return unit;
}

/// With a true minus sign, and never "-0".
std::string number(double value, int decimals) {
  const double rounded = std::abs(value) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : value;
  auto text = fmt::format("{:.{}f}", rounded, decimals);
  if (text.front() == '-') text.replace(0, 1, "−");
  return text;
}

std::string power_of_ten(int exponent) {
  static constexpr std::array<std::string_view, 10> kSuperscripts = {"⁰", "¹", "²", "³", "⁴",
                                                                     "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent)))
    text += kSuperscripts[static_cast<std::size_t>(digit - '0')];
  return text;
}

std::string log_tick_text(double value, int mantissa, int exponent, const std::string& unit) {
  if (takes_prefix(unit)) {
    const auto prefixed = prefixed_unit(unit, value);
    return fmt::format("{:.4g} {}", value / prefixed.factor, prefixed.text);
  }
  if (exponent >= -3 && exponent <= 4) return fmt::format("{:.4g}", value);
  const auto power = power_of_ten(exponent);
  return mantissa == 1 ? power : fmt::format("{}·{}", mantissa, power);
}

std::vector<Tick> log_ticks(const Scale& scale, const std::string& unit, int most) {
  const int first = static_cast<int>(std::floor(std::log10(scale.low)));
  const int last = static_cast<int>(std::ceil(std::log10(scale.high)));
  const int every = std::max(1, (last - first + most) / (most + 1));
  const bool few = last - first <= 2;
  std::vector<Tick> ticks;
  for (int exponent = first; exponent <= last; ++exponent) {
    if ((exponent - first) % every != 0) continue;
    for (const int mantissa : {1, 2, 5}) {
      if (mantissa != 1 && !few) continue;
      const double value = mantissa * std::pow(10.0, exponent);
      // Rounding may put a tick on the end of the scale just outside.
      if (value < scale.low * (1 - 1e-9) || value > scale.high * (1 + 1e-9)) continue;
      ticks.push_back({value, log_tick_text(value, mantissa, exponent, unit)});
    }
  }
  return ticks;
}

/// As many notes of each octave as leave at most `most` ticks, or else every second, third, ... A.
std::vector<Tick> note_ticks(const Scale& scale, int most) {
  std::vector<Tick> ticks;
  const auto collect = [&](const auto& is_ticked) {
    ticks.clear();
    const double low = kA4 + kSemitonesOfOctave * std::log2(scale.low / 440);
    const double high = kA4 + kSemitonesOfOctave * std::log2(scale.high / 440);
    for (int note = static_cast<int>(std::ceil(low - 1e-9)); note <= high + 1e-9; ++note)
      if (const double hertz = pitch_of_note(note); is_ticked(note))
        ticks.push_back({hertz, fmt::format("{} {:.0f} Hz", note_name(hertz), hertz)});
    return std::ssize(ticks) <= std::max(1, most);
  };
  // From C on: all notes, the natural ones, C E A, E A.
  for (const std::string_view octave : {"xxxxxxxxxxxx", "x.x.xx.x.x.x", "x...x....x..", "....x....x.."})
    if (collect([&](int note) { return octave[static_cast<std::size_t>(semitones_above_c(note))] == 'x'; }))
      return ticks;
  for (int octaves = 1;
       !collect([&](int note) { return (note - kA4) % (octaves * kSemitonesOfOctave) == 0; });)
    ++octaves;
  return ticks;
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least this.
double nice_step(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double nice : {1.0, 2.0, 5.0})
    if (nice * power >= least * (1 - 1e-9)) return nice * power;
  return 10.0 * power;
}

}  // namespace

Range range_of(const PlotAxis& axis, double low, double high, bool margin) {
  if (!(low <= high)) low = axis.log ? 1.0 : 0.0, high = 1.0;  // nothing to show
  double bottom = axis.log ? std::log(low) : low;
  double top = axis.log ? std::log(high) : high;
  if (bottom == top) {
    const double room = axis.log || bottom == 0.0 ? 1.0 : 0.5 * std::abs(bottom);
    bottom -= room;
    top += room;
  }
  const double extra = margin ? 0.06 * (top - bottom) : 0.0;
  bottom -= extra;
  top += extra;
  const double from = axis.low.value_or(axis.log ? std::exp(bottom) : bottom);
  const double to = axis.high.value_or(axis.log ? std::exp(top) : top);
  // A given limit may lie beyond all data: the other end then follows it.
  if (from < to) return {from, to};
  return axis.low ? Range{from, axis.log ? from * 10.0 : from + 1.0}
                  : Range{axis.log ? to / 10.0 : to - 1.0, to};
}

PrefixedUnit prefixed_unit(const std::string& unit, double largest) {
  if (!takes_prefix(unit) || !(largest > 0.0) || !std::isfinite(largest)) return {pretty(unit), 1.0};
  // 1e-9: a limit of exactly 1 mm is written in mm.
  const int thousand = static_cast<int>(std::floor(std::log10(largest) / 3.0 + 1e-9));
  const int step = std::clamp(thousand, -4, 4);
  return {std::string{kPrefixes[static_cast<std::size_t>(step + 4)]} + pretty(unit), std::pow(1000.0, step)};
}

std::vector<Tick> ticks_of(const Scale& scale, const PlotAxis& axis, const PrefixedUnit& prefixed, int most) {
  if (axis.notes) return note_ticks(scale, most);
  if (scale.log)
    if (auto ticks = log_ticks(scale, axis.unit, most); ticks.size() > 1 || scale.high >= 10 * scale.low)
      return ticks;
  const double low = scale.low / prefixed.factor;
  const double high = scale.high / prefixed.factor;
  double step = nice_step((high - low) / std::max(1, most));
  if (std::floor(high / step + 1e-9) <= std::ceil(low / step - 1e-9))
    step = nice_step(step / 2.5);  // one tick gives no scale
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  const auto own_unit = scale.log && takes_prefix(axis.unit) ? " " + prefixed.text : std::string{};
  std::vector<Tick> ticks;
  for (double n = std::ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n += 1.0)
    ticks.push_back({n * step * prefixed.factor, number(n * step, decimals) + own_unit});
  return ticks;
}

std::string axis_title(const PlotAxis& axis, const PrefixedUnit& prefixed) {
  if (prefixed.text.empty() || (axis.log && takes_prefix(axis.unit))) return axis.label;
  return axis.label.empty() ? "[" + prefixed.text + "]" : axis.label + " [" + prefixed.text + "]";
}

}  // namespace tactus::plot
