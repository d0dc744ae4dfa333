#include "engine/nodes/filters/mode_table.h"

#include <algorithm>
#include <cmath>

#include "engine/dsp/resonators/mode_series.h"

namespace tactus {
namespace {

constexpr int kMostModes = 4096;
constexpr double kLowestHz = 1, kShortestS = 1e-4, kLongestS = 1e4;

ModeSeries series_of(const std::string& word) {
  if (word == "geometric") return ModeSeries::Geometric;
  if (word == "bar") return ModeSeries::Bar;
  if (word == "clamped_bar") return ModeSeries::ClampedBar;
  if (word == "membrane") return ModeSeries::Membrane;
  return ModeSeries::Harmonic;
}

Result<std::vector<double>> listed_frequencies(const std::vector<double>& list) {
  if (list.empty() || list.size() > kMostModes)
    return fail(Errc::OutOfRange, {},
                "'frequencies' has " + std::to_string(list.size()) + " numbers, and there are from 1 to " +
                    std::to_string(kMostModes) + " modes",
                "list one frequency a mode");
  for (const double f : list)
    if (!(f >= kLowestHz))
      return fail(Errc::OutOfRange, {}, "one of 'frequencies' is below 1 Hz", "leave it out");
  return list;
}

Result<std::vector<double>> frequencies_of(const NodeSetup& setup) {
  const auto& list = setup.setting("frequencies");
  if (list.given && setup.setting("series").given)
    return fail(Errc::OutOfRange, {}, "'frequencies' and 'series' both say where the modes lie",
                "leave one of them out");
  if (list.given) return listed_frequencies(list.numbers);
  return mode_ratios(series_of(setup.setting("series").text), static_cast<int>(setup.setting("modes").number),
                     setup.setting("span").number);
}

double clamped(double x, double low, double high) { return x > low ? std::min(x, high) : low; }

}  // namespace

Result<std::vector<double>> one_each(const SettingValue& list, std::string_view name, std::size_t modes,
                                     double otherwise) {
  if (!list.given) return std::vector<double>(modes, otherwise);
  if (list.numbers.size() == 1) return std::vector<double>(modes, list.numbers[0]);
  if (list.numbers.size() == modes) return list.numbers;
  return fail(Errc::OutOfRange, {},
              "'" + std::string(name) + "' has " + std::to_string(list.numbers.size()) + " numbers for " +
                  std::to_string(modes) + " modes",
              "give one number for all modes, or one for each");
}

Result<ModeTable> ModeTable::make(const NodeSetup& setup) {
  ModeTable table;
  auto frequencies = frequencies_of(setup);
  if (!frequencies) return tl::unexpected(frequencies.error());
  table.frequencies_ = std::move(*frequencies);
  table.frequency_moves_ = !setup.setting("frequencies").given || setup.input("frequency").connected;

  const auto& list = setup.setting("decays");
  auto decays = one_each(list, "decays", table.size(), 1);
  if (!decays) return tl::unexpected(decays.error());
  table.decays_ = std::move(*decays);
  table.decay_moves_ = !list.given || setup.input("decay").connected;
  const double slope = list.given ? 0 : setup.setting("decay_slope").number;
  for (std::size_t k = 0; k < table.size(); ++k)
    table.decays_[k] = clamped(table.decays_[k] * table.falling(k, slope), kShortestS, kLongestS);
  return table;
}

double ModeTable::falling(std::size_t mode, double slope) const {
  return std::pow(frequencies_[0] / frequencies_[mode], slope);
}

double ModeTable::frequency_hz(std::size_t mode, double first_hz) const noexcept {
  if (!frequency_moves_) return frequencies_[mode];
  return clamped(first_hz, kLowestHz, 1e6) * (frequencies_[mode] / frequencies_[0]);
}

double ModeTable::decay_s(std::size_t mode, double first_s) const noexcept {
  if (!decay_moves_) return decays_[mode];
  return clamped(first_s, kShortestS, kLongestS) * (decays_[mode] / decays_[0]);
}

InputPort mode_frequency_input(bool fixed) {
  return {.name = "frequency",
          .unit = "Hz",
          .doc =
              "of the first mode, which the others follow; left out where `frequencies` are listed: as they "
              "are",
          .fallback = 220,
          .low = 0,
          .fixed = fixed};
}

InputPort mode_decay_input(bool fixed) {
  return {.name = "decay",
          .unit = "s",
          .doc =
              "time in which the first mode falls by 60 dB; the others keep their ratio to it; left out "
              "where `decays` are listed: as they are",
          .fallback = 0.1,
          .low = 0,
          .fixed = fixed};
}

std::vector<Setting> mode_settings(std::vector<Setting> further) {
  std::vector<Setting> settings = {
      {.name = "frequencies",
       .kind = Setting::Kind::Numbers,
       .doc = "of the modes, instead of a series",
       .choices = {"Hz"},
       .optional = true},
      {.name = "decays",
       .kind = Setting::Kind::Numbers,
       .doc = "time in which each mode falls by 60 dB, instead of a slope; one for all, or one a mode",
       .choices = {"s"},
       .optional = true},
      {.name = "series",
       .kind = Setting::Kind::Choice,
       .doc = "harmonic: 1, 2, 3 …; geometric: even steps of pitch; bar: free at both ends (marimba); "
              "clamped_bar: held at one end (kalimba); membrane: a drum's head",
       .choices = {"harmonic", "geometric", "bar", "clamped_bar", "membrane"},
       .fallback = "harmonic"},
      {.name = "modes",
       .kind = Setting::Kind::Integer,
       .doc = "of a series",
       .fallback = "16",
       .low = 1,
       .high = kMostModes},
      {.name = "span",
       .kind = Setting::Kind::Quantity,
       .doc = "last frequency of a geometric series over the first",
       .fallback = "16",
       .low = 1,
       .high = 1e4},
      {.name = "decay_slope",
       .kind = Setting::Kind::Quantity,
       .doc = "s in decay_k = decay (f_1 / f_k)^s: high modes die sooner where it is above 0",
       .fallback = "0.5",
       .low = -4,
       .high = 4}};
  for (auto& setting : further) settings.push_back(std::move(setting));
  return settings;
}

}  // namespace tactus
