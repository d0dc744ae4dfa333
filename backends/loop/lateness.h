#pragma once

#include <cstdint>
#include <vector>

#include "backends/loop/loop_card.h"

namespace tactus {

/// By how many frames the input of a simulated card is later than usual: what this opening added, a clock
/// that runs away, and frames that got lost or came twice.
class Lateness {
 public:
  struct Gaps {
    int count = 0;
    std::int64_t lost_frames = 0;
  };

  /// [control] `least`: it cannot be earlier, since that has not been played yet.
  Lateness(const LoopCard& card, Hertz sample_rate, double at_start, double least)
      : drops_(card.drops),
        sample_rate_(sample_rate),
        growth_(card.input_ppm * 1e-6 / (1.0 + card.input_ppm * 1e-6)),
        at_start_(at_start),
        least_(least) {}

  /// [realtime] Adds to `gaps` what gets lost at `frame`. Frames come one after another.
  double at(std::int64_t frame, Gaps& gaps) noexcept;

 private:
  bool happens(const LoopCard::Drop& drop, std::int64_t frame) const noexcept;

  std::vector<LoopCard::Drop> drops_;
  Hertz sample_rate_;
  double growth_, at_start_, least_;
};

}  // namespace tactus
