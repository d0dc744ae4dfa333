#pragma once

#include <array>
#include <cstdint>

#include "engine/core/index.h"
#include "engine/graph/node.h"

namespace tactus {

/// Where the frames of a part lie that runs at 1/R of the engine's rate: its frame m at engine frame R m,
/// whatever the blocks are. Computed once per sub-block, so that no step divides.
struct RateDivider {
  int divisor = 1;                                      ///< R
  int offset = 0;                                       ///< of the first frame in this sub-block
  std::int64_t number = 0;                              ///< m of that frame
  std::array<std::uint8_t, kMaxSubBlock + 1> before{};  ///< [offset in the sub-block] frames before it

  /// [realtime] For the sub-block of `frames` frames from `now` on.
  void begin(std::int64_t now, int frames) noexcept {
    number = (now + divisor - 1) / divisor;
    offset = static_cast<int>(number * divisor - now);
    int next = offset;
    std::uint8_t count = 0;
    for (int i = 0; i <= frames; ++i) {
      before[index(i)] = count;
      if (i != next) continue;
      ++count;
      next += divisor;
    }
  }
  /// [realtime] How many frames lie before this offset.
  int count(int to) const noexcept { return before[index(to)]; }
  /// [realtime] Where the `index`th frame of the sub-block lies.
  int place(int index) const noexcept { return offset + index * divisor; }
};

}  // namespace tactus
