#pragma once

#include <array>
#include <cstdint>

#include "engine/graph/node.h"

namespace tactus {

/// Where the frames of a part lie that runs at 1/R of the engine's rate: its frame m at engine frame R m,
/// whatever the blocks are. Worked out for a piece at a time, so that no step divides.
struct Pace {
  int every = 1;                                     ///< R
  int offset = 0;                                    ///< of the first one in this piece
  std::int64_t number = 0;                           ///< m of that one
  std::array<std::uint8_t, kMaxPiece + 1> before{};  ///< [offset in the piece] how many lie before it

  /// [realtime] For the piece of `frames` frames from `now` on.
  void begin(std::int64_t now, int frames) noexcept {
    number = (now + every - 1) / every;
    offset = static_cast<int>(number * every - now);
    int next = offset;
    std::uint8_t count = 0;
    for (int i = 0; i <= frames; ++i) {
      before[static_cast<std::size_t>(i)] = count;
      if (i != next) continue;
      ++count;
      next += every;
    }
  }
  /// [realtime] How many lie before this offset.
  int count(int to) const noexcept { return before[static_cast<std::size_t>(to)]; }
  /// [realtime] Where the `index`th of the piece lies.
  int place(int index) const noexcept { return offset + index * every; }
};

}  // namespace tactus
