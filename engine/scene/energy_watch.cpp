#include "engine/scene/energy_watch.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/core/named.h"

namespace tactus {
void EnergyWatch::take(const double* force, const double* position, int frames) noexcept {
  for (int n = 0; n < frames; ++n, ++frame_) {
    // Nothing was done before the first frame.
    if (frame_ > 0) sum_ += force[n] * (position[n] - position_);
    position_ = position[n];
    lowest_ = std::min(lowest_, sum_);
    const double given = sum_ - lowest_;
    if (given > given_) {
      given_ = given;
      most_at_ = frame_;
    }
    if (given > port_.allowed && active_at_ < 0) {
      active_at_ = frame_;
      given_when_active_ = given;
    }
  }
}

PortEnergy EnergyWatch::energy(Hertz sample_rate) const {
  PortEnergy energy{port_, sum_, given_};
  if (active_at_ < 0) return energy;
  energy.active_at_s = static_cast<double>(active_at_) / sample_rate.value;
  const auto rising = static_cast<double>(most_at_ - active_at_) / sample_rate.value;
  if (rising > 0) energy.growth_w = (given_ - given_when_active_) / rising;
  return energy;
}

PortWatches::PortWatches(const SceneSpec& scene, const std::vector<SceneTap>& plant_taps) {
  for (const auto& port : scene.ports) {
    const auto *force = find_named(plant_taps, port.force.name),
               *position = find_named(plant_taps, port.position.name);
    if (force == nullptr || position == nullptr) continue;
    const auto tap = [&](const SceneTap* named) { return static_cast<int>(named - plant_taps.data()); };
    watched_.push_back({tap(force), tap(position), EnergyWatch{port}});
  }
}

void PortWatches::take(const Player& plant, int frames) noexcept {
  for (auto& [force, position, watch] : watched_) watch.take(plant.tap(force), plant.tap(position), frames);
}

std::vector<PortEnergy> PortWatches::energies(Hertz sample_rate) const {
  std::vector<PortEnergy> energies;
  for (const auto& watched : watched_) energies.push_back(watched.watch.energy(sample_rate));
  return energies;
}

std::string describe(const PortEnergy& energy) {
  const auto gave = fmt::format("{:.3g} J ({:.3g} J allowed)", energy.given, energy.allowed);
  if (!energy.active_at_s) return fmt::format("{}: delivered at most {}", energy.name, gave);
  return fmt::format(
      "{}: the loop became active at {:.3g} s: it delivered {}, {:.3g} W on average from then on",
      energy.name, *energy.active_at_s, gave, energy.growth_w);
}

}  // namespace tactus
