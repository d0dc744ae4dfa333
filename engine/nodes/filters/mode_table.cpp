#include "engine/nodes/filters/mode_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/dsp/resonators/mode_series.h"
#include "engine/nodes/declare.h"

namespace tactus {
namespace {

constexpr int kMaxModes = 4096;
constexpr double kLowestMode_hz = 1, kHighestMode_hz = 1e6, kShortestDecay_s = 1e-4, kLongestDecay_s = 1e4;

constexpr std::array kSeries = {"harmonic", "geometric", "bar", "clamped_bar", "membrane"};

ModeSeries series_of(const std::string& word) {  // in the order of the words
  return static_cast<ModeSeries>(std::find(kSeries.begin(), kSeries.end(), word) - kSeries.begin());
}

Result<std::vector<double>> listed_frequencies(const std::vector<double>& list) {
  if (list.empty() || list.size() > kMaxModes)
    return fail(Errc::OutOfRange, {},
                "'frequencies' has " + std::to_string(list.size()) + " numbers; allowed are 1 to " +
                    std::to_string(kMaxModes) + " modes",
                "list one frequency per mode");
  for (const double f : list)
    if (!(f >= kLowestMode_hz))
      return fail(Errc::OutOfRange, {}, "one of 'frequencies' is below 1 Hz", "remove it");
  return list;
}

Result<std::vector<double>> frequencies_of(const NodeSetup& setup) {
  const auto& list = setup.setting("frequencies");
  if (list.given && setup.setting("series").given)
    return fail(Errc::OutOfRange, {}, "'frequencies' and 'series' both determine the mode frequencies",
                "omit one of them");
  if (list.given) return listed_frequencies(list.numbers);
  return mode_ratios(series_of(setup.setting("series").text), static_cast<int>(setup.setting("modes").number),
                     setup.setting("span").number);
}

double clamped_mode(double x, double low, double high) { return x > low ? std::min(x, high) : low; }

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
    table.decays_[k] =
        clamped_mode(table.decays_[k] * table.falling(k, slope), kShortestDecay_s, kLongestDecay_s);
  return table;
}

double ModeTable::falling(std::size_t mode, double slope) const {
  return std::pow(frequencies_[0] / frequencies_[mode], slope);
}

double ModeTable::frequency_hz(std::size_t mode, double first_hz) const noexcept {
  if (!frequency_moves_) return frequencies_[mode];
  return clamped_mode(first_hz, kLowestMode_hz, kHighestMode_hz) * (frequencies_[mode] / frequencies_[0]);
}

double ModeTable::decay_s(std::size_t mode, double first_s) const noexcept {
  if (!decay_moves_) return decays_[mode];
  return clamped_mode(first_s, kShortestDecay_s, kLongestDecay_s) * (decays_[mode] / decays_[0]);
}

InputPort mode_frequency_input() {
  return {.name = "frequency",
          .unit = "Hz",
          .doc =
              "frequency of the first mode; the others keep their ratio to it; default if `frequencies` are "
              "listed: their first",
          .fallback = 220,
          .low = kLowestMode_hz,
          .high = kHighestMode_hz};
}

InputPort mode_decay_input() {
  return {.name = "decay",
          .unit = "s",
          .doc =
              "time in which the first mode decays by 60 dB; the others keep their ratio to it; default if "
              "`decays` are listed: their first",
          .fallback = 0.1,
          .low = kShortestDecay_s,
          .high = kLongestDecay_s};
}

std::vector<Setting> mode_settings(std::vector<Setting> further) {
  std::vector<Setting> settings = {
      {"frequencies", Setting::Kind::Numbers, "frequencies of the modes, instead of a series", {"Hz"}},
      {"decays",
       Setting::Kind::Numbers,
       "time in which each mode decays by 60 dB, instead of a slope: one number for all, or one per mode",
       {"s"}},
      choice("series",
             "frequency ratios. harmonic: 1, 2, 3 …; geometric: equal pitch steps; bar: free at both ends "
             "(marimba); clamped_bar: clamped at one end (kalimba); membrane: drum head",
             {kSeries.begin(), kSeries.end()}, "harmonic"),
      within(1, kMaxModes,
             {"modes",
              Setting::Kind::Integer,
              "number of modes of the harmonic, bar or membrane series",
              {},
              "16"}),
      within(1, 1e4,
             {"span",
              Setting::Kind::Quantity,
              "ratio of the last to the first frequency of a geometric series",
              {},
              "16"}),
      within(-4, 4,
             {"decay_slope",
              Setting::Kind::Quantity,
              "exponent s in decay_k = decay * (f_1 / f_k)^s; above 0: high modes decay faster",
              {},
              "0.5"})};
  for (auto& setting : further) settings.push_back(std::move(setting));
  return settings;
}

}  // namespace tactus
