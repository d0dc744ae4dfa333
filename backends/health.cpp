#include "backends/health.h"

#include <algorithm>

namespace tactus {

const char* name_of(Gap gap) {
  constexpr std::array<const char*, kGaps> kNames{"input", "output", "server", "unsaid"};
  return kNames[static_cast<std::size_t>(gap)];
}

Health together(const Health& before, const Health& after) {
  if (after.blocks == 0 && after.xruns == 0) return before;
  if (before.blocks == 0 && before.xruns == 0) return after;
  Health both = after;
  both.blocks += before.blocks;
  both.frames += before.frames;
  both.seconds += before.seconds;
  both.xruns += before.xruns;
  for (std::size_t g = 0; g < kGaps; ++g) both.gaps[g] += before.gaps[g];
  both.lost_frames += before.lost_frames;
  both.late_blocks += before.late_blocks;
  both.bad_input += before.bad_input;
  if (before.blocks > 0)
    both.shortest_block =
        after.blocks > 0 ? std::min(before.shortest_block, after.shortest_block) : before.shortest_block;
  both.longest_block = std::max(before.longest_block, after.longest_block);
  if (both.blocks > 0)
    both.mean_load = (before.mean_load * static_cast<double>(before.blocks) +
                      after.mean_load * static_cast<double>(after.blocks)) /
                     static_cast<double>(both.blocks);
  both.peak_load = std::max(before.peak_load, after.peak_load);
  return both;
}

}  // namespace tactus
