#pragma once

// Thread: [realtime].

#include <algorithm>
#include <array>

#include "engine/dsp/filters/recurrence.h"
#include "engine/graph/node.h"

namespace tactus {

/// Cuts a block where parameters may change: `update(frame)` at each group start (and at the very first frame
/// of a node), `run(from, to, position)` on the frames between. Where the parameters are constant there is
/// one run for all whole groups.
class GroupSteps {
 public:
  void reset() noexcept { fresh_ = true; }

  /// For a block of one frame: updates where that is due, gives back the position.
  template <class Update>
  int single(const NodeBlock& block, Update update) noexcept {
    const int position = group_position(block.first_frame);
    if (position == 0 || fresh_) update();
    fresh_ = false;
    return position;
  }

  template <class Update, class Run>
  void go(const NodeBlock& block, bool constant, Update update, Run run) noexcept {
    for (int from = 0; from < block.frames;) {
      const int position = group_position(block.first_frame + from);
      if (position == 0 || fresh_) update(from);
      fresh_ = false;
      const int to =
          constant && position == 0 ? block.frames : std::min(block.frames, from + kGroup - position);
      run(from, to, position);
      from = to;
    }
  }

 private:
  bool fresh_ = true;
};

/// Whether `count` inputs from `first` on rest.
inline bool rest(const NodeBlock& block, std::size_t first, std::size_t count) noexcept {
  bool all = true;
  for (std::size_t i = first; i < first + count; ++i) all = all && block.in[i].constant();
  return all;
}

/// The samples of a signal in a row; a constant is written out.
class InARow {
 public:
  const double* operator()(const Signal& signal, int frames) noexcept {
    if (!signal.constant()) return signal.data;
    std::fill_n(samples_.begin(), frames, signal[0]);
    return samples_.data();
  }

 private:
  std::array<double, kMaxSubBlock> samples_;
};

}  // namespace tactus
