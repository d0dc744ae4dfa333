#pragma once
// Thread: [control]

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/json.h"
#include "engine/core/units.h"

namespace tactus::app {

/// How many events there are in an object of EventCollector::json.
inline std::size_t count_of(const Json& events) { return events["events"].size(); }

/// The events of a run from its taps "node.output", whose samples above 0.5 are events, and "node.level": a
/// level counts the envelope 5 ms after the event, or at the next one. Keeps events, no samples.
class EventCollector {
 public:
  EventCollector(const std::vector<std::string>& taps, Hertz sample_rate);

  /// The next `frames` samples of each tap.
  void add(const std::vector<const double*>& taps, int frames);
  /// {"events": [{"time_s", "node", "level_db"}]}, in the order of their times. The run is over.
  Json json();

 private:
  struct Event {
    double time_s = 0;
    std::optional<double> level{};
  };
  struct Track {
    std::string node;
    std::size_t tap = 0;
    std::optional<std::size_t> level_tap{};
    bool high = false;
    std::int64_t level_frame = -1;  ///< whose level counts for the last event; -1: it is known
    std::vector<Event> events{};
    double last_level = 0;  ///< of the frame before
  };

  void add(Track& track, const double* samples, const double* levels, int frames) const;
  std::int64_t frame_at(double time_s) const {
    return static_cast<std::int64_t>(time_s * sample_rate_.value);
  }

  Hertz sample_rate_;
  std::vector<Track> tracks_;
  std::int64_t frame_ = 0;
};

}  // namespace tactus::app
