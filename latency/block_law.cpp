#include "latency/block_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

std::string ms(Seconds time) { return fmt::format("{:.2f} ms", 1e3 * time.value); }

/// The one with the largest block of those that are shorter than the best and had gaps.
const SettingDelay* nearest_bad(const std::vector<SettingDelay>& settings, const SettingDelay& best) {
  const SettingDelay* nearest = nullptr;
  const auto block_s = [](const auto& setting) { return setting.block_frames / setting.sample_rate.value; };
  for (const auto& setting : settings)
    if (!setting.good() && block_s(setting) < block_s(best) &&
        (nearest == nullptr || setting.block_frames > nearest->block_frames))
      nearest = &setting;
  return nearest;
}

std::string fault_of(const SettingDelay& setting) {
  if (setting.finding.verdict != Verdict::Ok) return code(setting.finding.verdict);
  return setting.gaps == 1 ? "one gap" : fmt::format("{} gaps", setting.gaps);
}

}  // namespace

std::optional<BlockLaw> fit_block_law(const std::vector<SettingDelay>& settings) {
  auto good = settings;
  std::erase_if(good, [](const SettingDelay& setting) { return !setting.good(); });
  const auto count = static_cast<double>(good.size());
  double mean_block = 0.0, mean_delay = 0.0;
  for (const auto& setting : good) {
    mean_block += setting.block_frames / count;
    mean_delay += setting.delay_frames / count;
  }
  double spread = 0.0, together = 0.0;
  for (const auto& setting : good) {
    const double block = setting.block_frames - mean_block;
    spread += block * block;
    together += block * (setting.delay_frames - mean_delay);
  }
  if (!(spread > 0.0)) return std::nullopt;
  BlockLaw law;
  law.settings = static_cast<int>(good.size());
  law.sample_rate = good.front().sample_rate;
  law.periods = good.front().periods;
  law.per_frame = together / spread;
  law.fixed_frames = mean_delay - law.per_frame * mean_block;
  if (good.size() < 3) return law;
  double squares = 0.0;
  for (const auto& setting : good)
    squares += std::pow(setting.delay_frames - law.at(setting.block_frames), 2);
  const double variance = squares / (count - 2);
  law.residual_frames = std::sqrt(variance);
  law.per_frame_standard_error = std::sqrt(variance / spread);
  law.fixed_standard_error = std::sqrt(variance * (1 / count + mean_block * mean_block / spread));
  return law;
}

const SettingDelay* shortest_good(const std::vector<SettingDelay>& settings, Seconds least) {
  const SettingDelay* shortest = nullptr;
  for (const auto& setting : settings)
    if (setting.good() && setting.delay() > least &&
        (shortest == nullptr || setting.delay() < shortest->delay()))
      shortest = &setting;
  return shortest;
}

std::vector<std::vector<SettingDelay>> by_rate_and_periods(const std::vector<SettingDelay>& settings) {
  std::vector<std::vector<SettingDelay>> groups;
  for (const auto& setting : settings) {
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& other) {
      return other.front().sample_rate == setting.sample_rate && other.front().periods == setting.periods;
    });
    if (group == groups.end()) group = groups.emplace(group);
    group->push_back(setting);
  }
  return groups;
}

std::string setting_text(const SettingDelay& setting) {
  return fmt::format("{} frames{}, {:g} kHz", setting.block_frames,
                     setting.periods > 0 ? fmt::format(", {} periods", setting.periods) : "",
                     setting.sample_rate.value / 1e3);
}

std::string recommendation(const std::vector<SettingDelay>& settings) {
  if (settings.empty()) return "Nothing was measured.";
  const auto* best = shortest_good(settings);
  if (best == nullptr) {
    const auto& last = settings.back();
    if (last.finding.verdict == Verdict::Ok)
      return "No setting ran without a gap: try larger blocks, and run tactus doctor.";
    return fmt::format("No setting gave a reliable result ({}): {}.", code(last.finding.verdict),
                       last.finding.remedy.empty() ? last.finding.what : last.finding.remedy);
  }
  auto text = fmt::format("Play with {}: {}, and no frame was lost in {:.0f} s.", setting_text(*best),
                          ms(best->delay()), best->measured_s);
  if (const auto* bad = nearest_bad(settings, *best))
    text += fmt::format(" At a shorter delay, {} had {}.", setting_text(*bad), fault_of(*bad));
  if (const auto* next = shortest_good(settings, best->delay()))
    text += fmt::format(
        " An instrument loads the processor more than a measurement: if gaps occur, use {}, which adds {}.",
        setting_text(*next), ms(next->delay() - best->delay()));
  return text;
}

}  // namespace tactus
