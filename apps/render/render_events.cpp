#include "apps/render/render_events.h"

#include <algorithm>
#include <utility>

#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "engine/core/port_name.h"

namespace tactus::app {
namespace {

constexpr double kLevelAfter_s = 5e-3;

Json event_json(double time_s, const std::string& node, std::optional<double> level) {
  Json json{{"time_s", time_s}, {"node", node}};
  if (level && *level > 0) json["level_db"] = amplitude_to_db(*level);
  return json;
}

}  // namespace

EventCollector::EventCollector(const std::vector<std::string>& taps, Hertz sample_rate)
    : sample_rate_(sample_rate) {
  for (std::size_t t = 0; t < taps.size(); ++t) {
    const EventSignal event{taps[t]};
    if (event.is_level) continue;
    tracks_.push_back({event.node, t});
    const auto level = std::ranges::find(taps, event.level_of);
    if (level != taps.end()) tracks_.back().level_tap = static_cast<std::size_t>(level - taps.begin());
  }
}

void EventCollector::add(const std::vector<const double*>& taps, int frames) {
  for (auto& track : tracks_)
    add(track, taps[track.tap], track.level_tap ? taps[*track.level_tap] : nullptr, frames);
  frame_ += frames;
}

void EventCollector::add(Track& track, const double* samples, const double* levels, int frames) const {
  const auto take_level = [&](std::int64_t frame) {
    track.events.back().level = frame < frame_ ? track.last_level : levels[frame - frame_];
    track.level_frame = -1;
  };
  for (int n = 0; n < frames; ++n) {
    const bool now = samples[n] > 0.5;
    if (now && !track.high) {
      const double time_s = static_cast<double>(frame_ + n) / sample_rate_.value;
      if (track.level_frame >= 0) take_level(std::min(track.level_frame, frame_at(time_s)));
      track.events.push_back({time_s});
      if (levels != nullptr) track.level_frame = frame_at(time_s + kLevelAfter_s);
    }
    track.high = now;
    if (track.level_frame == frame_ + n) take_level(frame_ + n);
  }
  if (levels != nullptr) track.last_level = levels[frames - 1];
}

Json EventCollector::json() {
  std::vector<std::pair<double, Json>> events;  // with their times
  for (auto& track : tracks_) {
    if (track.level_frame >= 0) track.events.back().level = track.last_level;
    for (const auto& [time_s, level] : track.events)
      events.emplace_back(time_s, event_json(time_s, track.node, level));
  }
  std::ranges::stable_sort(events, {}, &std::pair<double, Json>::first);
  return {{"events", list_of(events, [](const auto& event) { return event.second; })}};
}

}  // namespace tactus::app
