#pragma once

// Thread: [control]

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/play/play_report.h"
#include "engine/runtime/player.h"

namespace tactus::app {

/// Keeps the instrument's taps while an offline run goes by: each block of the engine is followed by one of
/// the sink.
class EventRecorder {
 public:
  EventRecorder(const Player& engine, std::vector<std::string> names)
      : engine_(engine), names_(std::move(names)), taps_(names_.size()) {}

  void take(int frames) {
    for (std::size_t t = 0; t < taps_.size(); ++t)
      taps_[t].insert(taps_[t].end(), engine_.tap(static_cast<int>(t)),
                      engine_.tap(static_cast<int>(t)) + frames);
  }
  nlohmann::ordered_json events(Hertz sample_rate) const { return events_json(names_, taps_, sample_rate); }

 private:
  const Player& engine_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> taps_;
};

}  // namespace tactus::app
